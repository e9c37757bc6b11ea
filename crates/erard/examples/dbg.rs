use erard::{assembly, equilibrium, instrument::Instrument, mechanism::mechanism};
use moreau::*;
fn main() {
    let instrument = Instrument::builtin("concert-grand").unwrap();
    let mut rest = mechanism(&instrument, Settings::new(50e-6)).unwrap();
    equilibrium::settle(rest.as_mut(), &Input::Free).unwrap();
    let angles = core::array::from_fn(|i| rest.angles()[i]);
    let model: Model<f64,6,14> = assembly::assemble(&instrument).unwrap();
    let mut state = State::at_rest(angles);
    let mut scratch = Scratch::<f64, 6, 14, 10>::new();
    let s = Settings::new(50e-6);
    let mut per = [[0u64;4]; 20];
    for n in 0..20000u64 {
        let f = if n < 10000 {5.0} else {0.0};
        let r = step(&model,&s,&Input::Force(f),&mut state,&mut scratch);
        let k=(n/1000) as usize;
        per[k][0]+=r.newton as u64; per[k][1]+=r.solver as u64;
        per[k][2]+= state.velocity.iter().filter(|v| **v==0.0).count() as u64;
        if n%1000==500 || (n>5000 && n<5006) {println!("{n} {:?} {:?} {:?} {:?}", r.solver, state.velocity, state.pivot_friction, state.tangential);}
    }
    for k in 0..20 {println!("{:?}", per[k]);}
}
