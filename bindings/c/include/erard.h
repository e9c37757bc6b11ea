/* liberard: the grand piano action, stepped from outside. Made from bindings/c/src by cbindgen: do not edit.
 *
 * Units are SI; key and finger are positive downward (pushing), the hammer upward.
 *
 * Who owns what: an object belongs to whoever made it, until its free function; a char* that is not const belongs to the caller, until erard_text_free; a
 * const char* is the library's. Every pointer may be NULL: where it must not be, the call says ERARD_STATUS_NULL and does nothing.
 *
 * Real time: functions marked "Real time: yes" never allocate, lock, or call the system, and do a bounded amount of work. All others may.
 *
 * Threads: objects are independent. One object may be used by one thread at a time, by any; nothing is locked for you.
 *
 * Errors: a status below 0 means that nothing has changed. Functions that are not for real time say more in erard_last_error.
 *
 * The floating-point environment must be the usual one (round to nearest). Denormal numbers: the library neither sets nor clears the
 * processor's flush-to-zero mode; either mode is fine, and the README says what it costs. */

#ifndef ERARD_H
#define ERARD_H

#include <stddef.h>
#include <stdint.h>

/**
 * The version of this interface: the layout of structures and the meaning of functions. A library of another version
 * cannot be used with this header; compare with erard_abi().
 */
#define ERARD_ABI 1

/**
 * Largest force that an action takes, N, up or down: a hundred times a fortissimo.
 */
#define ERARD_LARGEST_FORCE_N 10000.0

/**
 * Largest position that an action takes, m from rest, up or down: ten times a key's dip.
 */
#define ERARD_LARGEST_POSITION_M 0.1

/**
 * Largest speed that an action takes, m/s, up or down.
 */
#define ERARD_LARGEST_SPEED_M_PER_S 100.0

/**
 * Longest time that erard_advance takes at once, s.
 */
#define ERARD_LONGEST_ADVANCE_S 1.0

/**
 * ErardInput.kind: nothing touches the key.
 */
#define ERARD_FREE 0

/**
 * ErardInput.kind: a force on the key front (admittance).
 */
#define ERARD_FORCE 1

/**
 * ErardInput.kind: the driver's end of a soft fingertip is somewhere and moves (impedance). The fingertip only pushes.
 */
#define ERARD_MOTION 2

/**
 * ErardInput.kind: the key front itself is somewhere and moves, imposed. Not for a loop with a device: see "Closed
 * loop" in the README.
 */
#define ERARD_RIGID 3

/**
 * ErardInput.kind: a hand, a mass that muscle moves, behind a soft fingertip. Its place and speed are part of the
 * action's state; erard_place_hand sets them.
 */
#define ERARD_HAND 4

/**
 * Most steps that erard_keyboard_step takes at once.
 */
#define ERARD_MOST_STEPS 1000000

/**
 * Steps are halved as often as the strings ask while a hammer is near them, as at first. Impacts are converged; the
 * step in which ten of them happen at once in the top octave takes fifteen times as long.
 */
#define ERARD_HALVE_AS_ASKED 0

/**
 * All steps are whole: every one takes about the same time. Impacts on strings are then as accurate as the step is
 * short; at 1/24000 s the contact of the top octave lasts a sixth too long.
 */
#define ERARD_HALVE_NEVER 1

/**
 * How a call ended. Zero is success, above zero a success with a remark, below zero an error: nothing has changed
 * then.
 */
enum ErardStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Done.
   */
  ERARD_STATUS_OK = 0,
  /**
   * Done; a step reached its iteration limit, and its error may be larger than the tolerance.
   */
  ERARD_STATUS_ITERATION_LIMIT = 1,
  /**
   * A pointer that must not be NULL is.
   */
  ERARD_STATUS_NULL = -1,
  /**
   * An argument is not one of those that are allowed: a kind of input, a name, a number of steps.
   */
  ERARD_STATUS_ARGUMENT = -2,
  /**
   * A number is not finite, or became so in the step.
   */
  ERARD_STATUS_NOT_FINITE = -3,
  /**
   * A number is beyond ERARD_LARGEST_FORCE_N, ERARD_LARGEST_POSITION_M, ERARD_LARGEST_SPEED_M_PER_S, or a step or
   * time beyond its range.
   */
  ERARD_STATUS_RANGE = -4,
  /**
   * There is no such key, body, zone, screw or number.
   */
  ERARD_STATUS_NO_SUCH = -5,
  /**
   * The caller's memory is too small; the size that is needed has been written.
   */
  ERARD_STATUS_SIZE = -6,
  /**
   * The bytes are no saved state of this version, or damaged.
   */
  ERARD_STATUS_SAVED = -7,
  /**
   * The bytes are the state of another instrument, or of another length of step.
   */
  ERARD_STATUS_FOREIGN = -8,
  /**
   * The text of the file is wrong: erard_last_error says where.
   */
  ERARD_STATUS_FILE = -9,
  /**
   * The file reads, but what it describes cannot be assembled, finds no rest, or cannot be measured or regulated.
   */
  ERARD_STATUS_MODEL = -10,
  /**
   * The caller's progress function ended the work.
   */
  ERARD_STATUS_INTERRUPTED = -11,
  /**
   * A fault of this library. The object may be freed and, if it is an action, reset or restored; nothing else.
   */
  ERARD_STATUS_INTERNAL = -12,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ErardStatus ErardStatus;
#else
typedef int32_t ErardStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * One action under the caller's control. It belongs to whoever made it, until erard_action_free. One thread at a time
 * may use it; any thread may.
 */
typedef struct ErardAction ErardAction;

/**
 * An instrument that was read from its file's text, and that text. It belongs to whoever made it, until
 * erard_instrument_free. It never changes but by erard_instrument_set and erard_instrument_vary; several threads may
 * read it at once.
 */
typedef struct ErardInstrument ErardInstrument;

/**
 * A whole keyboard under the caller's control. It belongs to whoever made it, until erard_keyboard_free. One thread at
 * a time may use it.
 */
typedef struct ErardKeyboard ErardKeyboard;

/**
 * A stroke over time, ready to drive actions of one instrument, a step after the other. It belongs to whoever made it,
 * until erard_stroke_free. One thread at a time may use it.
 */
typedef struct ErardStroke ErardStroke;

/**
 * Looks at an action while it is pressed, and finds the instants of one press. It belongs to whoever made it, until
 * erard_watch_free.
 */
typedef struct ErardWatch ErardWatch;

/**
 * Reading after a step: positions and speeds at its end, from rest; forces as they acted in it.
 */
typedef struct ErardReading {
  /**
   * The present instant, s from the action's creation or its last reset.
   */
  double time_s;
  /**
   * Travel of the key front, m.
   */
  double key_m;
  /**
   * Its speed, m/s.
   */
  double key_m_per_s;
  /**
   * Force of the finger on the key in the last step, N: what a haptic key has to give back.
   */
  double finger_n;
  /**
   * Mean finger force over all steps of the call that made this reading, N: for a device that is slower than the
   * steps.
   */
  double finger_mean_n;
  /**
   * Rise of the hammer's strike point, m.
   */
  double hammer_m;
  /**
   * How fast it rises, m/s.
   */
  double hammer_m_per_s;
  /**
   * Force between hammer and string, N, never negative.
   */
  double string_n;
  /**
   * Instant of the last impact of the hammer on its string, s; 0 before the first.
   */
  double impact_time_s;
  /**
   * Total speed of the strike point at that impact, m/s; 0 before the first.
   */
  double hammer_speed_m_per_s;
  /**
   * Number of impacts since the action was created or reset.
   */
  uint32_t impact_count;
  /**
   * Number of impacts in the call that made this reading.
   */
  uint32_t new_impact_count;
  /**
   * Place of the hand, m below the key front's rest; where none presses, where the last one was.
   */
  double hand_m;
  /**
   * Its speed, m/s.
   */
  double hand_m_per_s;
} ErardReading;

/**
 * Input of a key. Fields that its kind does not use are ignored.
 */
typedef struct ErardInput {
  /**
   * ERARD_FREE, ERARD_FORCE, ERARD_MOTION, ERARD_RIGID or ERARD_HAND.
   */
  uint32_t kind;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * N, down positive; of a hand, its muscle's force.
   */
  double force_n;
  /**
   * m below the key front's rest; of a hand, where its muscle holds it.
   */
  double position_m;
  /**
   * m/s, down positive; of a hand, the velocity toward which its muscle damps it.
   */
  double velocity_m_per_s;
  /**
   * Hand: effective mass at the fingertip, kg, 0.001 to 100.
   */
  double hand_mass_kg;
  /**
   * Hand: stiffness with which the muscle holds it at position_m, N/m, 0 to 1e7; 0 for none.
   */
  double muscle_n_per_m;
  /**
   * Hand: damping of the muscle, N s/m, 0 to 1e5.
   */
  double muscle_n_s_per_m;
} ErardInput;

/**
 * An impact of a hammer on its string.
 */
typedef struct ErardImpact {
  /**
   * The key, from 1.
   */
  uint32_t key;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * Instant of the impact, s.
   */
  double time_s;
  /**
   * Total speed of the strike point at the impact, m/s.
   */
  double hammer_speed_m_per_s;
} ErardImpact;

/**
 * Called now and then during long work with the share that is done, 0 to 1, and the caller's own pointer; 0 ends the
 * work.
 */
typedef int32_t (*ErardProgress)(double share, void *user);

/**
 * The instants of one press, s on the action's clock, and what follows from them; NaN for what has not happened.
 */
typedef struct ErardEvents {
  /**
   * The key front leaves its rest: a tenth of a millimetre.
   */
  double key_start_s;
  /**
   * The jack's toe meets the let-off button.
   */
  double toe_contact_s;
  /**
   * The last push on the knuckle before the string ends.
   */
  double let_off_s;
  /**
   * First impact of the hammer on the string.
   */
  double hammer_contact_s;
  /**
   * Total speed of the strike point at that impact, m/s.
   */
  double hammer_speed_m_per_s;
  /**
   * The key meets its front punching.
   */
  double key_bottom_s;
  /**
   * After the impact, the hammer's tail meets the back check.
   */
  double check_s;
  /**
   * From let-off to the impact, s.
   */
  double free_flight_s;
  /**
   * From the impact to the key's bottom, s; negative where the key is down first.
   */
  double key_bottom_after_impact_s;
} ErardEvents;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The version of this library, e.g. "0.1.0"; never NULL. Real time: yes.
 */
const char *erard_version(void);

/**
 * The version of this interface: ERARD_ABI of the header that the library was built with. Real time: yes.
 */
uint32_t erard_abi(void);

/**
 * The error of this thread's last failed call, the real-time functions excepted (they return a status and keep no
 * text): a line in UTF-8, for a file with its line and key. Empty where nothing failed. It is the library's, and lasts
 * until the next such call fails.
 */
const char *erard_last_error(void);

/**
 * Meaning of a status, a line in English; never NULL. Real time: yes.
 */
const char *erard_status_text(int32_t status);

/**
 * Gives back a text of the library. NULL does nothing. Real time: no.
 */
void erard_text_free(char *text);

/**
 * So many bytes of memory, set to zero, for callers that have none of their own to pass: a page. NULL for 0 bytes.
 * Give it back with erard_memory_free. Real time: no.
 */
uint8_t *erard_memory_new(size_t bytes);

/**
 * Gives back memory of erard_memory_new, with its size. NULL does nothing. Real time: no.
 */
void erard_memory_free(uint8_t *memory, size_t bytes);

/**
 * Makes an action at rest, with nothing touching its key, from the text of an instrument file (UTF-8, `length` bytes;
 * no terminating zero is needed). NULL and 0 give the built-in concert grand. `step_s` is the length of a step, s:
 * usually 50e-6, or 1/24000 with modal strings, near which every step is halved as often as needed. Returns NULL on
 * failure: `status` (which may be NULL) receives the reason, and erard_last_error describes it. Real time: no (it
 * reads, allocates, and simulates until the action rests).
 */
struct ErardAction *erard_action_new(const char *text, size_t length, double step_s, ErardStatus *status);

/**
 * Makes an action of an instrument; the action does not need the instrument afterwards. Real time: no.
 */
struct ErardAction *erard_action_of(const struct ErardInstrument *instrument, double step_s, ErardStatus *status);

/**
 * Ends an action. NULL does nothing. Real time: no.
 */
void erard_action_free(struct ErardAction *action);

/**
 * One step under a force on the key front, N, down positive (admittance: force in, position out). `reading` may be
 * NULL. An error leaves the action as it was. Real time: yes.
 */
ErardStatus erard_step_force(struct ErardAction *action, double force_n, struct ErardReading *reading);

/**
 * One step under a device that is at `position_m` below the key's rest and moves at `velocity_m_per_s`, down positive,
 * in the middle of the step (impedance: position in, force out: finger_n of the reading). Between device and key is
 * the fingertip of the instrument's file, a spring and a damper that only push: the virtual coupling. `reading` may be
 * NULL. An error leaves the action as it was. Real time: yes.
 */
ErardStatus erard_step_motion(struct ErardAction *action,
                              double position_m,
                              double velocity_m_per_s,
                              struct ErardReading *reading);

/**
 * One step with the key front imposed: where it is at the step's end, and how fast. For measured strokes, not for a
 * loop with a device (README, "Closed loop"). `reading` may be NULL. An error leaves the action as it was. Real time:
 * yes.
 */
ErardStatus erard_step_rigid(struct ErardAction *action,
                             double position_m,
                             double velocity_m_per_s,
                             struct ErardReading *reading);

/**
 * One step with nothing touching the key. `reading` may be NULL. Real time: yes.
 */
ErardStatus erard_step_free(struct ErardAction *action, struct ErardReading *reading);

/**
 * One step under an input of any kind (a hand among them). `reading` may be NULL. An error leaves the action as it
 * was. Real time: yes.
 */
ErardStatus erard_step_input(struct ErardAction *action, const struct ErardInput *input, struct ErardReading *reading);

/**
 * Places the hand (ERARD_HAND), m below the key front's rest, with a velocity, m/s, down positive. A new action has it
 * at the key front's rest; it moves in steps that a hand drives only. Real time: yes.
 */
ErardStatus erard_place_hand(struct ErardAction *action, double position_m, double velocity_m_per_s);

/**
 * As many steps as `dt_s` has room for, for a device that is slower than the steps (0 to ERARD_LONGEST_ADVANCE_S);
 * what is left over counts for the next call, so that times of any length do not drift. The input holds at the
 * beginning of `dt_s`: a force is held, a position goes on at its velocity. The reading's finger_mean_n is what to
 * render: the device that holds it gives back the same impulse. If a step fails none has been taken. Real time: yes,
 * and its time is that of its steps.
 */
ErardStatus erard_advance(struct ErardAction *action,
                          double dt_s,
                          const struct ErardInput *input,
                          struct ErardReading *reading);

/**
 * Reads the action now: after a step, the reading that the step wrote. Real time: yes.
 */
ErardStatus erard_read(const struct ErardAction *action, struct ErardReading *reading);

/**
 * As it was when it was made: at rest, at 0 s, no impact so far. Real time: yes.
 */
ErardStatus erard_reset(struct ErardAction *action);

/**
 * Writes all that the following steps depend on to `bytes`: what goes on from there gives the same bits. `size` says
 * how many bytes there are, and receives how many it takes: some 2.8 kB, the same for every action of one library
 * whose string is rigid; modal strings take 16 bytes more for each of their modes, and the size then belongs to the
 * action. The state is lists of numbers with names: what a later library adds, an earlier one passes over, and the
 * other way round it is absent. With `bytes` NULL it is only reported. The bytes are the same on every machine. Real
 * time: yes.
 */
ErardStatus erard_save(const struct ErardAction *action, uint8_t *bytes, size_t *size);

/**
 * Sends the rail that the sustain pedal lifts to a lift, m, from 0 to 0.010 (farther is as far as it goes; it moves at
 * 0.5 m/s at most). Without modal strings, or without a rail, it does nothing. Real time: yes.
 */
ErardStatus erard_set_pedal(struct ErardAction *action, double lift_m);

/**
 * Writes the force of the strings on the bridge now, N, to `force_n`, positive as the hammer pushes them; 0 for an
 * action without modal strings. The sound that `erard press --wav` writes is this less its value at rest. Real time:
 * yes.
 */
ErardStatus erard_bridge_force(const struct ErardAction *action, double *force_n);

/**
 * The places at which erard_string_shape looks at the middle string, m from the striking point, away from its nearer
 * end: as many as `count` has room for are written to `places_m` (which may be NULL). Returns how many there are; 0
 * for an action without modal strings, and for NULL. Real time: yes.
 */
size_t erard_string_places(const struct ErardAction *action, double *places_m, size_t count);

/**
 * How far the middle string is from where it rests at each of its places, m, away from the hammer; `count` is the room
 * in `shape_m`, at least erard_string_places. Without modal strings it does nothing. Real time: yes.
 */
ErardStatus erard_string_shape(const struct ErardAction *action, float *shape_m, size_t count);

/**
 * Goes on from a saved state of the same instrument (its numbers count; its name, its notes and the order in its file
 * do not) and the same length of step, to the bit; readings are those of then. What is no such state is refused, and
 * the action stays as it was. Real time: yes.
 */
ErardStatus erard_restore(struct ErardAction *action, const uint8_t *bytes, size_t size);

/**
 * How many bodies it has; 0 for NULL. Real time: yes.
 */
size_t erard_body_count(const struct ErardAction *action);

/**
 * How many contact zones it has; 0 for NULL. Real time: yes.
 */
size_t erard_zone_count(const struct ErardAction *action);

/**
 * Name of a body, from 0, as its file gives it; NULL if there is no such body. It is the action's, and lasts as long.
 * Real time: yes.
 */
const char *erard_body_name(const struct ErardAction *action, size_t body);

/**
 * Name of a contact zone, from 0; as erard_body_name. Real time: yes.
 */
const char *erard_zone_name(const struct ErardAction *action, size_t zone);

/**
 * Absolute angles of all bodies, rad, counter-clockwise seen with the player to the left; `count` is the room in
 * `angles_rad`, at least erard_body_count. Real time: yes.
 */
ErardStatus erard_angles(const struct ErardAction *action, double *angles_rad, size_t count);

/**
 * Absolute angular velocities of all bodies, rad/s; as erard_angles. Real time: yes.
 */
ErardStatus erard_velocities(const struct ErardAction *action, double *velocities_rad_s, size_t count);

/**
 * Normal forces of all contact zones in the last step, N, never negative; `count` is the room in `forces_n`, at least
 * erard_zone_count. After a restore or a reset they are 0 until the next step. Real time: yes.
 */
ErardStatus erard_contact_forces(const struct ErardAction *action, double *forces_n, size_t count);

/**
 * Makes 88 keys at rest from the text of a keyboard file (UTF-8, `length` bytes) whose base instrument is built in.
 * NULL and 0 give the built-in concert grand. Each key has an input that holds until it is changed; at first
 * ERARD_FREE. Returns NULL on failure: `status` (which may be NULL) receives the reason, and erard_last_error describes
 * it. Real time: no (it takes about half a second).
 */
struct ErardKeyboard *erard_keyboard_new(const char *text, size_t length, double step_s, ErardStatus *status);

/**
 * A built-in keyboard by its name, as erard_keyboard_new makes one of a text: `concert-grand`, or
 * `concert-grand-strings`, whose strings sound. NULL where there is none of that name, and as there. Real time: no.
 */
struct ErardKeyboard *erard_keyboard_builtin(const char *called, double step_s, ErardStatus *status);

/**
 * Ends a keyboard. NULL does nothing. Real time: no.
 */
void erard_keyboard_free(struct ErardKeyboard *keyboard);

/**
 * How many keys it has; 0 for NULL. They count from 1, the lowest A. Real time: yes.
 */
uint32_t erard_keyboard_keys(const struct ErardKeyboard *keyboard);

/**
 * How many keys are awake: those cost time. 0 for NULL. Real time: yes.
 */
uint32_t erard_keyboard_awake(const struct ErardKeyboard *keyboard);

/**
 * Sets the input of a key, from 1, from the next step on. The position of ERARD_MOTION holds, whatever its velocity
 * says: give a new one as often as it moves. Real time: yes.
 */
ErardStatus erard_keyboard_drive(struct ErardKeyboard *keyboard, uint32_t key, const struct ErardInput *input);

/**
 * Places the hand (ERARD_HAND) on a key, from 1, as erard_place_hand does. Real time: yes.
 */
ErardStatus erard_keyboard_place_hand(struct ErardKeyboard *keyboard,
                                      uint32_t key,
                                      double position_m,
                                      double velocity_m_per_s);

/**
 * Sends the sustain pedal's rail to a lift, m, under all keys that have one, as erard_set_pedal does. Real time: yes.
 */
ErardStatus erard_keyboard_set_pedal(struct ErardKeyboard *keyboard, double lift_m);

/**
 * Writes the force of a key's strings on the bridge now, N, to `force_n`, as erard_bridge_force does. Real time: yes.
 */
ErardStatus erard_keyboard_bridge_force(const struct ErardKeyboard *keyboard, uint32_t key, double *force_n);

/**
 * Writes the force of the strings of all keys on the bridge now, N, to `force_n`, with what the dampers at rest press;
 * 0 where none sound. Real time: yes.
 */
ErardStatus erard_keyboard_bridge_sum(const struct ErardKeyboard *keyboard, double *force_n);

/**
 * So many steps (1 to ERARD_MOST_STEPS) of all keys that are awake. The impacts in them are written to `impacts`, in
 * their order, as many as `capacity` says; `count` (which may be NULL) receives how many there were: those beyond are
 * lost. A key whose numbers became infinite stays where it was, and the status says so; the others have gone on. Real
 * time: yes.
 */
ErardStatus erard_keyboard_step(struct ErardKeyboard *keyboard,
                                uint32_t steps,
                                struct ErardImpact *impacts,
                                size_t capacity,
                                size_t *count);

/**
 * Reads a key, from 1, after the last step. finger_mean_n is that of the last step; new_impact_count is 0. Real time:
 * yes.
 */
ErardStatus erard_keyboard_read(const struct ErardKeyboard *keyboard, uint32_t key, struct ErardReading *reading);

/**
 * Writes the absolute angles of a key's bodies, rad, in the order of its instrument's, as erard_angles does for one
 * action: `count` says for how many there is room. Real time: yes.
 */
ErardStatus erard_keyboard_angles(const struct ErardKeyboard *keyboard, uint32_t key, double *angles_rad, size_t count);

/**
 * Writes all that the following steps depend on, inputs and instant among it; as erard_save (about 220 kB). Real time:
 * yes.
 */
ErardStatus erard_keyboard_save(const struct ErardKeyboard *keyboard, uint8_t *bytes, size_t *size);

/**
 * Goes on from a saved state of the same keyboard and the same length of step: the same bits for every key, instants
 * to a rounding. What is no such state is refused, and the keyboard stays as it was. Forces read 0 until the next
 * step. Real time: yes.
 */
ErardStatus erard_keyboard_restore(struct ErardKeyboard *keyboard, const uint8_t *bytes, size_t size);

/**
 * Whether an action's steps are halved while its hammer is near strings that sound (ERARD_HALVE_AS_ASKED, as at first,
 * or ERARD_HALVE_NEVER), from the next step on. No saved state holds this: choose it again after making an action.
 * Without strings that sound it changes nothing. Real time: no (it may allocate); choose before the loop.
 */
ErardStatus erard_halve(struct ErardAction *action, uint32_t kind);

/**
 * Chooses the halving of steps for all keys of a keyboard; wakes them. Real time: no.
 */
ErardStatus erard_keyboard_halve(struct ErardKeyboard *keyboard, uint32_t kind);

/**
 * Reads the text of an instrument file (UTF-8, `length` bytes); NULL and 0: the built-in concert grand. NULL where
 * something is wrong with it: `status` (which may be NULL) and erard_last_error say what; erard_check says it for
 * programs. Real time: no, as everything here.
 */
struct ErardInstrument *erard_instrument_new(const char *text, size_t length, ErardStatus *status);

/**
 * A built-in instrument by its name, e.g. "heavy-touch". erard_builtin lists them.
 */
struct ErardInstrument *erard_instrument_builtin(const char *called, ErardStatus *status);

/**
 * The instrument of a key, 1 to 88, of the built-in keyboard `concert-grand`.
 */
struct ErardInstrument *erard_instrument_of_key(uint32_t key, ErardStatus *status);

/**
 * The instrument of a key, 1 to 88, of a built-in keyboard by its name, e.g. "concert-grand-strings". erard_builtin
 * lists them.
 */
struct ErardInstrument *erard_instrument_of_keyboard(const char *called, uint32_t key, ErardStatus *status);

/**
 * Ends an instrument. NULL does nothing. Actions that were made of it go on.
 */
void erard_instrument_free(struct ErardInstrument *instrument);

/**
 * The text of its file, as it is now. Give it back with erard_text_free. `length` may be NULL.
 */
char *erard_instrument_text(const struct ErardInstrument *instrument, size_t *length, ErardStatus *status);

/**
 * One number of the file, in the file's own unit, by its dotted path: "body.hammer.mass_g",
 * "zone.string.felt.exponent", "screw.let_off.setting_mm"; entries of a list by their name. `which` is 0, or for a
 * coordinate 0 or 1.
 */
ErardStatus erard_instrument_get(const struct ErardInstrument *instrument,
                                 const char *path,
                                 size_t which,
                                 double *value);

/**
 * Changes one number of the file, in the file's own unit. The text is read anew: what the file may not be is refused,
 * and the instrument stays as it was. Actions that were made of it before stay as they are.
 */
ErardStatus erard_instrument_set(struct ErardInstrument *instrument, const char *path, size_t which, double value);

/**
 * The instrument as JSON: name, description, gravity_m_s2, bodies, zones and screws by name, and its numbers with
 * path, values, line and source. Give it back with erard_text_free.
 */
char *erard_instrument_json(const struct ErardInstrument *instrument, size_t *length, ErardStatus *status);

/**
 * Whether a text is a sound instrument or keyboard file, as JSON: {"kind", "sound", "name", "errors"}; each error with
 * "line" and "column" (from 1), "key", "message", "found", "expected", the bytes from "begin" to "end", and "text",
 * all of it in a line. A reader stops at the first error. `text` is UTF-8 of `length` bytes, or not: that is an error,
 * too. Give the JSON back with erard_text_free.
 */
char *erard_check(const char *text, size_t length, size_t *json_length, ErardStatus *status);

/**
 * The built-in instruments and keyboards, as JSON: {"instruments": [...], "keyboards": [...]}. Give it back with
 * erard_text_free.
 */
char *erard_builtin(size_t *length, ErardStatus *status);

/**
 * Changes what a person calls by one name, as the command's `--vary` does: `called` is "body.hammer.mass" (a body's
 * mass and, in proportion, its inertia), "let_off", "zone.check.friction", or the path of a number; `change` is "8.7
 * g", "+0.8 g", "-0.2 mm", "*1.5" or "= 0.2". The numbers are put into the file's text, to ten digits, and the text is
 * read anew: what the file may not be is refused, and the instrument stays as it was. Actions that were made of it
 * before stay as they are. ERARD_STATUS_NO_SUCH: no such name; ERARD_STATUS_ARGUMENT: a change that cannot be read;
 * ERARD_STATUS_RANGE: too far; erard_last_error says what is expected.
 */
ErardStatus erard_instrument_vary(struct ErardInstrument *instrument, const char *called, const char *change);

/**
 * A picture of the instrument in one pose, as SVG: the same drawing as the command's. `angles_rad` are absolute angles
 * of its bodies, as erard_angles gives them; NULL and 0: as its file draws it. `size_px` is the larger side, px.
 * `labels`: 1 names the parts. Elements of a moving part carry `data-body`, its number. Give the text back with
 * erard_text_free.
 */
char *erard_draw(const struct ErardInstrument *instrument,
                 const double *angles_rad,
                 size_t count,
                 double size_px,
                 uint32_t labels,
                 size_t *length,
                 ErardStatus *status);

/**
 * Measures an instrument as a technician does, as JSON. `wanted` NULL: the whole sheet, as `erard measure --json` has
 * it for an instrument; else some of its lines, separated by commas ("down_weight_g,dip_mm"), as an object of their
 * values, which costs only what they need. `progress` may be NULL. Takes from tenths of a second to seconds. Give the
 * text back with erard_text_free.
 */
char *erard_measure(const struct ErardInstrument *instrument,
                    const char *wanted,
                    ErardProgress progress,
                    void *user,
                    size_t *length,
                    ErardStatus *status);

/**
 * Turns an instrument's screws until its action meets goals, as JSON: what became of every goal, the screws that were
 * turned, all distances before and after (the fields of the report that `erard regulate` writes), and "file", the text
 * of the instrument file with its new settings. The instrument itself stays as it is. `goals` NULL: the trade's norms;
 * else a JSON object of goals by name with values in mm (the spring in mm/s, the damper in %) or texts with units:
 * {"let-off": 1.5, "blow": "1.8in"}. `progress` may be NULL. Takes seconds. Give the text back with erard_text_free.
 */
char *erard_regulate(const struct ErardInstrument *instrument,
                     const char *goals,
                     ErardProgress progress,
                     void *user,
                     size_t *length,
                     ErardStatus *status);

/**
 * Drawing of an instrument for a page that moves it, as JSON: "shapes" and "gradients" (SVG for a g and a defs
 * element; what moves carries `data-body`, or with the pedal's rail, `data-rail`), "bodies" with their hinges, angles
 * as drawn and masses, "zones" with the way their arrows point, "press", "pedal" (whether it has one), "string" (where
 * it is struck and how high it lies, null where it is rigid), "labels", "views" and the law of arrows; mm of the
 * picture. Give the text back with erard_text_free.
 */
char *erard_scene(const struct ErardInstrument *instrument, size_t *length, ErardStatus *status);

/**
 * The lines of the protocol sheet, as JSON: groups of "heading" and "lines", each line with "key" (as erard_measure
 * takes and gives it), "label", "unit", "decimals", and "usual" ([low, high], null where open) and "source" of its
 * norm at a key, 1 to 88. Give the text back with erard_text_free.
 */
char *erard_sheet(uint32_t key, size_t *length, ErardStatus *status);

/**
 * Diagnoses a key of a real piano from whatever was measured of it, as JSON: what `erard diagnose` writes to
 * diagnosis.json, with readings, causes, what to do and what to measure next. `readings` is a JSON object: "key" (1 to
 * 88, or a note; without it C4 is assumed, and "is_key_assumed" says so), "leads" ("14@165, 14@147") and readings by
 * the names of erard_diagnosable, as numbers or as texts with units. Takes up to seconds. Give the text back with
 * erard_text_free.
 */
char *erard_diagnose(const char *readings, size_t *length, ErardStatus *status);

/**
 * Everything that is wrong with readings for erard_diagnose, as JSON: an array of "name" (the reading's, "key" or
 * "leads"; empty where the fault belongs to none), "found" and "expected"; empty where they are sound. Give the text
 * back with erard_text_free.
 */
char *erard_diagnose_check(const char *readings, size_t *length, ErardStatus *status);

/**
 * What can be measured of a real piano's key, as JSON: an array of "name" (as erard_diagnose takes it), "label",
 * "unit", "decimals", "limits", "precision", "usual" ([low, high] at that key, 1 to 88; null where open or not this
 * key's) and "how" it is taken. Give the text back with erard_text_free.
 */
char *erard_diagnosable(uint32_t key, size_t *length, ErardStatus *status);

/**
 * Screws and parameters of an instrument that can be changed, as JSON: dials, each with "name", "label", "note",
 * "group", "unit", "decimals", "value", "from" and "to". Give the text back with erard_text_free.
 */
char *erard_dials(const struct ErardInstrument *instrument, size_t *length, ErardStatus *status);

/**
 * The instrument with dials turned, as a new one: `turns` is a JSON object of dials' names and values, {"let_off":
 * -0.5, "hammer": 9.5}. All count from this instrument, which stays as it is. What the file may not be is refused. It
 * belongs to the caller, until erard_instrument_free.
 */
struct ErardInstrument *erard_turned(const struct ErardInstrument *instrument, const char *turns, ErardStatus *status);

/**
 * Presses an instrument once, mezzo forte, and says whether it plays, as JSON: "hammer_speed_m_per_s" (null where the
 * hammer does not reach the string) and "warnings", sentences about what cannot be trusted or does not work. Takes a
 * tenth of a second. Give the text back with erard_text_free.
 */
char *erard_try(const struct ErardInstrument *instrument, size_t *length, ErardStatus *status);

/**
 * A watch for one press on an action of this instrument. NULL where there is no instrument. Real time: no.
 */
struct ErardWatch *erard_watch_new(const struct ErardInstrument *instrument, ErardStatus *status);

/**
 * Ends a watch. NULL does nothing. Real time: no.
 */
void erard_watch_free(struct ErardWatch *watch);

/**
 * Forgets what was seen: the next press is watched. Real time: no.
 */
ErardStatus erard_watch_again(struct ErardWatch *watch);

/**
 * Looks once: before the first step of a press, and after every one. Real time: no.
 */
ErardStatus erard_watch_look(struct ErardWatch *watch, const struct ErardAction *action);

/**
 * Reads the watch's observations so far. Real time: no.
 */
ErardStatus erard_watch_read(const struct ErardWatch *watch, struct ErardEvents *events);

/**
 * From now on an action keeps where its zones touch, for erard_contacts. It costs a few percent of a step and changes
 * no bit. Real time: no.
 */
ErardStatus erard_keep_contacts(struct ErardAction *action);

/**
 * How the contact zones acted in the last step, five numbers each: force, N; the point, m in the world, x to the back
 * and y up; the unit normal along which its disc's side is pushed. Zeros where nothing touches, and before
 * erard_keep_contacts. `count` is the room in `numbers`, at least five times erard_zone_count. Real time: no.
 */
ErardStatus erard_contacts(const struct ErardAction *action, double *numbers, size_t count);

/**
 * Whether the last step changed nothing, so that under the same input no later one does either: 1, else 0. 0 for NULL.
 * Real time: no.
 */
uint32_t erard_rests(const struct ErardAction *action);

/**
 * A built-in touch on an instrument: "pp", "p", "mf", "f" or "ff" (hammer speeds at the string of 0.5, 0.79, 1.99,
 * 3.15 and 5 m/s); `struck`: 0 for a pressed touch, 1 for a struck one. A hand of 200 g plays it; how strongly is
 * found on this instrument. Played on another action, it is the same hand. ERARD_ARGUMENT: no such hand reaches the
 * speed; erard_last_error says which it reaches. Real time: no.
 */
struct ErardStroke *erard_stroke_builtin(const struct ErardInstrument *instrument,
                                         const char *nuance,
                                         uint32_t struck,
                                         ErardStatus *status);

/**
 * A recorded stroke for an instrument, from the text of a CSV file (UTF-8, `length` bytes) with a column for the time
 * and one for force or position; it drives by its force where it has one, else by its position. It is prepared as
 * `erard press` does without options: the zero is taken from the rest before the touch, and what noise a channel has
 * is filtered; erard_stroke_told says so. What is wrong with it erard_last_error says with line and column. Real time:
 * no.
 */
struct ErardStroke *erard_stroke_new(const struct ErardInstrument *instrument,
                                     const char *text,
                                     size_t length,
                                     ErardStatus *status);

/**
 * Changes and remarks from the preparation of a recorded stroke, a line each; empty for one that is built in. Give the
 * text back with erard_text_free.
 */
char *erard_stroke_told(const struct ErardStroke *stroke, size_t *length, ErardStatus *status);

/**
 * Columns of a table that are read as a recording, as JSON: an array of "role" ("time", "force", "position",
 * "hammer"), "index" (from 0) and "title", time first. `titles` is a JSON array of all titles. For callers that read
 * tables that are not text, and pass their columns on as CSV. Give the text back with erard_text_free.
 */
char *erard_recording_columns(const char *titles, size_t *length, ErardStatus *status);

/**
 * Ends a stroke. NULL does nothing. Real time: no.
 */
void erard_stroke_free(struct ErardStroke *stroke);

/**
 * How long it takes, with what `erard press` lets the action swing out after it, s; 0 for NULL. Real time: no.
 */
double erard_stroke_duration(const struct ErardStroke *stroke);

/**
 * Begins it anew. Real time: no.
 */
ErardStatus erard_stroke_rewind(struct ErardStroke *stroke);

/**
 * One step of an action under the stroke's next input: from an action at rest the same bits as `erard press`. An error
 * leaves both as they were. `reading` may be NULL. Real time: no.
 */
ErardStatus erard_step_stroke(struct ErardAction *action, struct ErardStroke *stroke, struct ErardReading *reading);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ERARD_H */
