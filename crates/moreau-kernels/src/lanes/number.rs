//! Operations of vector numbers, written once for every width and precision.
//!
//! A module that uses these macros gives the lane type, the width, and the intrinsics. Its numbers are private to this
//! module and exist only inside the kernels of `kernels.rs`, which are entered after the processor has been asked for
//! their instructions. That is what makes the intrinsics sound.

/// An intrinsic, in code that only a kernel compiled for it reaches.
macro_rules! simd {
    ($e:expr) => {
        // SAFETY: the intrinsic asks for a processor that has its instructions. These numbers exist only in what
        // `kernels.rs` makes after it has found them.
        unsafe { $e }
    };
}

macro_rules! operator {
    ($number:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl core::ops::$trait for $number {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                $number(simd!($intrinsic(self.0, other.0)))
            }
        }
    };
}

/// A number of `$width` lanes of `$lane` in a `$register`, and all of `moreau::Real`. Comparisons are the module's
/// `less` and `at_most`, choices its `choose` and `kept`, absolute value and sign its `magnitude` and `negated`.
macro_rules! vector_number {
    (
        $number:ident, $mask:ident, $register:ident, $lane:ident, $width:literal,
        add: $add:ident, sub: $sub:ident, mul: $mul:ident, div: $div:ident,
        fused: $fused:ident, fused_minus: $fused_minus:ident,
        sqrt: $sqrt:ident, max: $max:ident, min: $min:ident, splat: $splat:ident, features: $features:literal,
        pow: $pow:path, tanh: $tanh:path, sincos: $sincos:path $(,)?
    ) => {
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub(crate) struct $number($register);

        impl From<[$lane; $width]> for $number {
            #[inline(always)]
            fn from(x: [$lane; $width]) -> Self {
                // SAFETY: both are the same number of bytes of plain numbers.
                $number(unsafe { core::mem::transmute::<[$lane; $width], $register>(x) })
            }
        }

        impl From<$number> for [$lane; $width] {
            #[inline(always)]
            fn from(x: $number) -> Self {
                // SAFETY: both are the same number of bytes of plain numbers.
                unsafe { core::mem::transmute::<$register, [$lane; $width]>(x.0) }
            }
        }

        impl core::fmt::Debug for $number {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                <[$lane; $width]>::from(*self).fmt(f)
            }
        }

        operator!($number, Add, add, $add);
        operator!($number, Sub, sub, $sub);
        operator!($number, Mul, mul, $mul);
        operator!($number, Div, div, $div);

        impl core::ops::Neg for $number {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                negated(self)
            }
        }

        impl core::ops::AddAssign for $number {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }

        impl core::ops::SubAssign for $number {
            #[inline(always)]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }

        impl $number {
            fn map(self, f: impl Fn($lane) -> $lane) -> Self {
                <[$lane; $width]>::from(self).map(f).into()
            }

            const fn constant(x: $lane) -> Self {
                // SAFETY: both are the same number of bytes of plain numbers.
                $number(unsafe { core::mem::transmute::<[$lane; $width], $register>([x; $width]) })
            }

            const fn constants<const K: usize>(x: [f64; K]) -> [Self; K] {
                let (mut all, mut k) = ([$number::constant(0.0); K], 0);
                while k < K {
                    all[k] = $number::constant(x[k] as $lane);
                    k += 1;
                }
                all
            }
        }

        impl moreau::Real for $number {
            type Mask = $mask;
            type Lane = $lane;
            const LANES: usize = $width;
            const ZERO: Self = $number::constant(0.0);
            const ONE: Self = $number::constant(1.0);
            const EPSILON: Self = $number::constant($lane::EPSILON);
            const SINE: &'static [Self; 6] = &$number::constants(moreau::SINE);
            const COSINE: &'static [Self; 6] = &$number::constants(moreau::COSINE);
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                $number(simd!($splat(x as $lane)))
            }
            #[inline(always)]
            fn join(x: impl Fn(usize) -> $lane) -> Self {
                core::array::from_fn::<$lane, $width, _>(x).into()
            }
            #[inline(always)]
            fn lane(self, lane: usize) -> $lane {
                <[$lane; $width]>::from(self)[lane]
            }
            #[inline(always)]
            fn lane_in(&self, lane: usize) -> $lane {
                // SAFETY: both are the same number of bytes of plain numbers, and the register's place is aligned to
                // more than a lane's.
                let all = unsafe { &*core::ptr::from_ref(self).cast::<[$lane; $width]>() };
                all[lane]
            }
            #[inline(always)]
            fn with_lane(self, lane: usize, x: $lane) -> Self {
                let mut all = <[$lane; $width]>::from(self);
                all[lane] = x;
                all.into()
            }
            #[inline(always)]
            fn add_product(self, a: Self, b: Self) -> Self {
                $number(simd!($fused(a.0, b.0, self.0)))
            }
            #[inline(always)]
            fn sub_product(self, a: Self, b: Self) -> Self {
                $number(simd!($fused_minus(a.0, b.0, self.0)))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $number(simd!($sqrt(self.0)))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                magnitude(self)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                // Of two numbers of which one is not a number, the intrinsic takes its second: here as in the scalar's
                // `if self < other`.
                $number(simd!($max(other.0, self.0)))
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                $number(simd!($min(other.0, self.0)))
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask {
                less(self, other)
            }
            #[inline(always)]
            fn le(self, other: Self) -> $mask {
                at_most(self, other)
            }
            #[inline(always)]
            fn finite(self) -> $mask {
                less(magnitude(self), Self::constant($lane::INFINITY))
            }
            #[inline(always)]
            fn select(mask: $mask, yes: Self, no: Self) -> Self {
                choose(mask, yes, no)
            }
            #[inline(always)]
            fn only(mask: $mask, x: Self) -> Self {
                kept(mask, x)
            }
            #[inline(always)]
            fn aside<W: moreau::Aside>(work: W) -> W::Output {
                #[cold]
                #[inline(never)]
                #[target_feature(enable = $features)]
                fn with_instructions<W: moreau::Aside>(work: W) -> W::Output {
                    work.run()
                }
                simd!(with_instructions(work))
            }
            #[inline(never)]
            fn powf(self, exponent: Self) -> Self {
                let (x, r) = (<[$lane; $width]>::from(self), <[$lane; $width]>::from(exponent));
                core::array::from_fn::<$lane, $width, _>(|i| $pow(x[i], r[i])).into()
            }
            #[inline(never)]
            fn tanh(self) -> Self {
                self.map($tanh)
            }
            #[inline(never)]
            fn sin_cos_any(self) -> (Self, Self) {
                let both = <[$lane; $width]>::from(self).map($sincos);
                (both.map(|(s, _)| s).into(), both.map(|(_, c)| c).into())
            }
        }
    };
}

/// Comparisons and choices of AVX2: all bits of a lane are set where it is true.
macro_rules! mask_of_bits {
    (
        $mask:ident, $number:ident, $register:ident, $lane:ident, $width:literal,
        compare: $compare:ident, blend: $blend:ident, and: $and:ident, and_not: $and_not:ident, or: $or:ident, xor: $xor:ident,
        movemask: $movemask:ident $(,)?
    ) => {
        #[derive(Clone, Copy)]
        #[repr(transparent)]
        pub(crate) struct $mask($register);

        #[inline(always)]
        fn less(a: $number, b: $number) -> $mask {
            $mask(simd!($compare::<_CMP_LT_OQ>(a.0, b.0)))
        }

        #[inline(always)]
        fn at_most(a: $number, b: $number) -> $mask {
            $mask(simd!($compare::<_CMP_LE_OQ>(a.0, b.0)))
        }

        #[inline(always)]
        fn choose(mask: $mask, yes: $number, no: $number) -> $number {
            $number(simd!($blend(no.0, yes.0, mask.0)))
        }

        #[inline(always)]
        fn kept(mask: $mask, x: $number) -> $number {
            $number(simd!($and(mask.0, x.0)))
        }

        #[inline(always)]
        fn magnitude(x: $number) -> $number {
            $number(simd!($and_not($number::constant(-0.0).0, x.0)))
        }

        #[inline(always)]
        fn negated(x: $number) -> $number {
            $number(simd!($xor(x.0, $number::constant(-0.0).0)))
        }

        impl core::fmt::Debug for $mask {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                <[$lane; $width]>::from($number(self.0)).map(|x| x.to_bits() != 0).fmt(f)
            }
        }

        impl moreau::Mask for $mask {
            #[inline(always)]
            fn any(self) -> bool {
                simd!($movemask(self.0)) != 0
            }
            #[inline(always)]
            fn all(self) -> bool {
                simd!($movemask(self.0)) == (1 << $width) - 1
            }
            #[inline(always)]
            fn and(self, other: Self) -> Self {
                $mask(simd!($and(self.0, other.0)))
            }
            #[inline(always)]
            fn or(self, other: Self) -> Self {
                $mask(simd!($or(self.0, other.0)))
            }
            #[inline(always)]
            fn not(self) -> Self {
                $mask(simd!($xor(self.0, Self::splat(true).0)))
            }
            #[inline(always)]
            fn splat(value: bool) -> Self {
                // All bits set, or none.
                let bits = if value { !0 } else { 0 };
                $mask($number::from([$lane::from_bits(bits); $width]).0)
            }
            #[inline(always)]
            fn lane(self, lane: usize) -> bool {
                simd!($movemask(self.0)) >> lane & 1 != 0
            }
        }
    };
}

pub(crate) use {mask_of_bits, operator, simd, vector_number};
