// C++17 classes over the C interface in erard.h, with C++ ownership and exceptions. Units and signs are as in erard.h.
//
// Constructors, `builtin`, `get`, `set`, `vary`, `toml` and `diagnose` throw erard::Error. The functions that return a
// status, which are those for real time, throw nothing: check the status. All set the sizes of structs.
#ifndef ERARD_HPP
#define ERARD_HPP

#include "erard.h"

#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace erard {

struct Error : std::runtime_error {
    ErardStatus status;
    explicit Error(ErardStatus s) : std::runtime_error(erard_last_error()), status(s) {}
};

namespace detail {
struct Free {
    void operator()(ErardAction *p) const { erard_action_free(p); }
    void operator()(ErardKeyboard *p) const { erard_keyboard_free(p); }
    void operator()(ErardInstrument *p) const { erard_instrument_free(p); }
    void operator()(char *p) const { erard_text_free(p); }
};
template <class T> using Owned = std::unique_ptr<T, Free>;
template <class T> Owned<T> owned(T *p, ErardStatus s) {
    if (!p) throw Error(s);
    return Owned<T>(p);
}
template <class T> T *sized(T &of) { of.struct_size = sizeof of; return &of; }
inline std::string text(char *p, ErardStatus s) { return owned(p, s).get(); }
} // namespace detail

class Instrument {
    detail::Owned<ErardInstrument> own;
    explicit Instrument(detail::Owned<ErardInstrument> p) : own(std::move(p)) {}

  public:
    explicit Instrument(std::string_view toml) {
        ErardStatus s;
        auto *p = erard_instrument_new(toml.data(), toml.size(), &s);
        own = detail::owned(p, s);
    }
    static Instrument builtin(const char *name) {
        ErardStatus s;
        auto *p = erard_instrument_builtin(name, &s);
        return Instrument(detail::owned(p, s));
    }
    double get(const char *path, std::size_t which = 0) const {
        double value;
        if (auto s = erard_instrument_get(own.get(), path, which, &value); s < 0) throw Error(s);
        return value;
    }
    void set(const char *path, double value, std::size_t which = 0) {
        if (auto s = erard_instrument_set(own.get(), path, which, value); s < 0) throw Error(s);
    }
    void vary(const char *name, const char *change) {
        if (auto s = erard_instrument_vary(own.get(), name, change); s < 0) throw Error(s);
    }
    std::string toml() const {
        ErardStatus s;
        char *p = erard_instrument_text(own.get(), nullptr, &s);
        return detail::text(p, s);
    }
    const ErardInstrument *handle() const noexcept { return own.get(); }
};

// Diagnoses a key of a real piano: takes readings and returns causes, both as JSON. See erard_diagnose.
inline std::string diagnose(const char *readings) {
    ErardStatus s;
    char *p = erard_diagnose(readings, nullptr, &s);
    return detail::text(p, s);
}

class Action {
    detail::Owned<ErardAction> own;

  public:
    explicit Action(double step_s = 50e-6) {
        ErardStatus s;
        auto *p = erard_action_new(nullptr, 0, step_s, &s);
        own = detail::owned(p, s);
    }
    explicit Action(const Instrument &of, double step_s = 50e-6) {
        ErardStatus s;
        auto *p = erard_action_of_instrument(of.handle(), step_s, &s);
        own = detail::owned(p, s);
    }
    [[nodiscard]] ErardStatus force(double n, ErardReading &r) noexcept { return erard_action_step_force(own.get(), n, detail::sized(r)); }
    [[nodiscard]] ErardStatus motion(double m, double m_per_s, ErardReading &r) noexcept {
        return erard_action_step_motion(own.get(), m, m_per_s, detail::sized(r));
    }
    [[nodiscard]] ErardStatus rigid(double m, double m_per_s, ErardReading &r) noexcept {
        return erard_action_step_rigid(own.get(), m, m_per_s, detail::sized(r));
    }
    [[nodiscard]] ErardStatus step(ErardInput in, ErardReading &r) noexcept { return erard_action_step_input(own.get(), detail::sized(in), detail::sized(r)); }
    [[nodiscard]] ErardStatus place_hand(double m, double m_per_s) noexcept { return erard_action_place_hand(own.get(), m, m_per_s); }
    [[nodiscard]] ErardStatus advance(double dt_s, ErardInput in, ErardReading &r) noexcept {
        return erard_action_advance(own.get(), dt_s, detail::sized(in), detail::sized(r));
    }
    [[nodiscard]] ErardStatus set_pedal(double lift_m) noexcept { return erard_action_set_pedal(own.get(), lift_m); }
    ErardReading reading() const noexcept {
        ErardReading r{};
        erard_action_read(own.get(), detail::sized(r));
        return r;
    }
    double bridge_force() const noexcept { double n = 0.0; erard_action_bridge_force(own.get(), &n); return n; }
    [[nodiscard]] ErardStatus pressure(double (&pa)[2]) noexcept { return erard_action_pressure(own.get(), pa); }
    std::vector<unsigned char> save() const {
        std::size_t n = 0;
        erard_action_save(own.get(), nullptr, &n);
        std::vector<unsigned char> bytes(n);
        erard_action_save(own.get(), bytes.data(), &n);
        return bytes;
    }
    [[nodiscard]] ErardStatus restore(const std::vector<unsigned char> &bytes) noexcept {
        return erard_action_restore(own.get(), bytes.data(), bytes.size());
    }
    void reset() noexcept { erard_action_reset(own.get()); }
    ErardAction *handle() noexcept { return own.get(); }
};

class Keyboard {
    detail::Owned<ErardKeyboard> own;
    explicit Keyboard(detail::Owned<ErardKeyboard> p) : own(std::move(p)) {}

  public:
    explicit Keyboard(double step_s = 50e-6) {
        ErardStatus s;
        auto *p = erard_keyboard_new(nullptr, 0, step_s, &s);
        own = detail::owned(p, s);
    }
    static Keyboard builtin(const char *name, double step_s = 50e-6) {
        ErardStatus s;
        auto *p = erard_keyboard_builtin(name, step_s, &s);
        return Keyboard(detail::owned(p, s));
    }
    [[nodiscard]] ErardStatus drive(std::uint32_t key, ErardInput in) noexcept {
        return erard_keyboard_drive(own.get(), key, detail::sized(in));
    }
    [[nodiscard]] ErardStatus place_hand(std::uint32_t key, double m, double m_per_s) noexcept {
        return erard_keyboard_place_hand(own.get(), key, m, m_per_s);
    }
    [[nodiscard]] ErardStatus set_pedal(double lift_m) noexcept { return erard_keyboard_set_pedal(own.get(), lift_m); }
    [[nodiscard]] ErardStatus read(std::uint32_t key, ErardReading &r) const noexcept {
        return erard_keyboard_read(own.get(), key, detail::sized(r));
    }
    [[nodiscard]] ErardStatus angles(std::uint32_t key, double *rad, std::size_t room) const noexcept {
        return erard_keyboard_angles(own.get(), key, rad, room);
    }
    double bridge_force(std::uint32_t key) const noexcept { double n = 0.0; erard_keyboard_bridge_force(own.get(), key, &n); return n; }
    double bridge_force() const noexcept { double n = 0.0; erard_keyboard_total_bridge_force(own.get(), &n); return n; }
    [[nodiscard]] ErardStatus pressure(double (&pa)[2]) noexcept { return erard_keyboard_pressure(own.get(), pa); }
    std::vector<unsigned char> save() const {
        std::size_t n = 0;
        erard_keyboard_save(own.get(), nullptr, &n);
        std::vector<unsigned char> bytes(n);
        erard_keyboard_save(own.get(), bytes.data(), &n);
        return bytes;
    }
    [[nodiscard]] ErardStatus restore(const std::vector<unsigned char> &bytes) noexcept {
        return erard_keyboard_restore(own.get(), bytes.data(), bytes.size());
    }
    [[nodiscard]] ErardStatus step(std::uint32_t steps, ErardImpact *impacts, std::size_t room, std::size_t &count) noexcept {
        return erard_keyboard_step(own.get(), steps, room ? detail::sized(*impacts) : nullptr, room, &count);
    }
    ErardKeyboard *handle() noexcept { return own.get(); }
};

} // namespace erard

#endif
