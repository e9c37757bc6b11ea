/* liberard: the grand piano action, stepped from outside. Made from bindings/c/src by cbindgen: do not edit.
 *
 * Units are SI. Key and finger are positive downward (pushing), the hammer upward.
 *
 * Ownership: an object belongs to the caller until its free function is called. A char* that is not const belongs to
 * the caller until erard_text_free. A const char* belongs to the library. Any pointer may be NULL: a call that needs it
 * then reports ERARD_STATUS_NULL and does nothing.
 *
 * Real time: functions marked "Real time: yes" never allocate, lock, or call the system, and do a bounded amount of
 * work. All others may.
 *
 * Threads: objects are independent. Any thread may use an object, but only one at a time; the library does not lock it.
 *
 * Structs: set the first field of a struct to its size before you pass it: `ErardReading reading = {.struct_size = sizeof
 * reading};`. In an array the size of the first element holds for all. Later versions add fields at the end of a struct
 * only. A header and a library of different versions therefore work together: the library writes the fields that both
 * know and sets the others of your struct to 0; of an input it reads the fields that both know and takes those missing
 * as 0. It returns ERARD_STATUS_STRUCT and does nothing if the size is none of this struct's, or if a field of an input
 * that it does not know is not 0.
 *
 * Errors: a status below 0 means that nothing has changed (for the one exception see erard_keyboard_step).
 * erard_last_error describes errors of functions that are not for real time.
 *
 * The floating-point environment must be the default one (round to nearest). Denormal numbers: the library neither sets
 * nor clears the processor's flush-to-zero mode. Either mode works; the README gives the cost of each. */

#ifndef ERARD_H
#define ERARD_H

#include <stddef.h>
#include <stdint.h>

/**
 * Version of this interface: the layout of its structures and the meaning of its functions. A library with another
 * version cannot be used with this header: check that erard_abi() returns this value.
 */
#define ERARD_ABI 1

/**
 * Largest force that an action accepts, N, up or down: a hundred times a fortissimo.
 */
#define ERARD_MAX_FORCE_N 10000.0

/**
 * Largest distance from rest that an action accepts, m, up or down: ten times a key's dip.
 */
#define ERARD_MAX_POSITION_M 0.1

/**
 * Largest speed that an action accepts, m/s, up or down.
 */
#define ERARD_MAX_SPEED_M_PER_S 100.0

/**
 * Longest time that one call of erard_action_advance accepts, s.
 */
#define ERARD_MAX_ADVANCE_S 1.0

/**
 * ErardInput.kind: nothing touches the key.
 */
#define ERARD_INPUT_FREE 0

/**
 * ErardInput.kind: a force on the key front (admittance).
 */
#define ERARD_INPUT_FORCE 1

/**
 * ErardInput.kind: prescribed position and velocity of the fingertip's driven end (impedance). The fingertip is soft
 * and can only push.
 */
#define ERARD_INPUT_MOTION 2

/**
 * ErardInput.kind: prescribed position and velocity of the key front itself. Do not use it in a loop with a device:
 * see "Closed loop" in the README.
 */
#define ERARD_INPUT_RIGID 3

/**
 * ErardInput.kind: a hand, which is a mass moved by a muscle, behind a soft fingertip. The hand's position and
 * velocity are part of the action's state; erard_action_place_hand sets them.
 */
#define ERARD_INPUT_HAND 4

/**
 * Largest number of steps that one call of erard_keyboard_step accepts.
 */
#define ERARD_MAX_STEPS 1000000

/**
 * Steps are halved as often as the strings need while a hammer is near them; the default. Impacts are converged. The
 * step in which ten impacts coincide in the top octave takes eight times as long.
 */
#define ERARD_HALVING_AUTO 0

/**
 * Steps are never halved, so all take about the same time. The accuracy of impacts then depends on the step length: at
 * 1/24000 s the contact of the top octave lasts a sixth too long.
 */
#define ERARD_HALVING_NEVER 1

/**
 * Steps are halved two times less often than the strings need: the worst step takes a third of the time, for loops
 * that play sound. Impacts are right to half a per cent, partials within 40 dB of the strongest to a decibel.
 */
#define ERARD_HALVING_FEWER 2

/**
 * ErardBoardSetup.kind: the sensors are under the keys of a real action, which move with their hammers. The motion of
 * each simulated key is prescribed (as by ERARD_INPUT_RIGID).
 */
#define ERARD_BOARD_ACTION 0

/**
 * ErardBoardSetup.kind: the sensors are under switches or light keys without an action. A hand of 200 g with at most
 * 60 N follows their depth (as by ERARD_INPUT_HAND).
 */
#define ERARD_BOARD_LIGHT 1

/**
 * ErardBoardSetup.sensor_law: travel in proportion to the reading.
 */
#define ERARD_SENSOR_LINEAR 0

/**
 * ErardBoardSetup.sensor_law: a reflective optical sensor CNY-70 under the back of a key.
 */
#define ERARD_SENSOR_CNY70 1

/**
 * ErardBoardSetup.sensor_law: a Hall sensor on the axis of a small magnet (`nearest_m`, `nearest_at_rest`).
 */
#define ERARD_SENSOR_HALL 2

/**
 * ErardBoardSetup.velocity_law: 52 + 25 log2(v), v in m/s, the convention of the command.
 */
#define ERARD_VELOCITY_USUAL 0

/**
 * ErardBoardSetup.velocity_law: `velocity_at_one` + `velocity_per_octave` log2(v), v in m/s.
 */
#define ERARD_VELOCITY_LOGARITHMIC 1

/**
 * ErardBoardSetup.velocity_law: in proportion to the speed, 127 at `velocity_full_m_per_s`.
 */
#define ERARD_VELOCITY_LINEAR 2

/**
 * Bytes of MIDI for which a call that plays keys needs room, for each key: eight messages.
 */
#define ERARD_BOARD_KEY_BYTES 48

/**
 * Most contacts of a key.
 */
#define ERARD_MAX_CONTACTS 3

/**
 * Most points of a table of contacts.
 */
#define ERARD_MAX_CONTACT_POINTS 24

/**
 * Outcome of a call. Zero is success, above zero success with a remark, below zero an error. An error means that
 * nothing has changed; the one exception is erard_keyboard_step.
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
   * Done, but a step reached its iteration limit and its error may exceed the tolerance.
   */
  ERARD_STATUS_ITERATION_LIMIT = 1,
  /**
   * A pointer is NULL that must not be.
   */
  ERARD_STATUS_NULL = -1,
  /**
   * An argument is not allowed: an unknown kind of input, a name that is not UTF-8, a value or JSON that cannot be
   * read.
   */
  ERARD_STATUS_ARGUMENT = -2,
  /**
   * A number is not finite, or became so during the step.
   */
  ERARD_STATUS_NOT_FINITE = -3,
  /**
   * A number is out of range: a force, position or speed beyond ERARD_MAX_FORCE_N, ERARD_MAX_POSITION_M or
   * ERARD_MAX_SPEED_M_PER_S, a step length, a time or a number of steps.
   */
  ERARD_STATUS_RANGE = -4,
  /**
   * No key, body, zone, screw, parameter or built-in has this name or number.
   */
  ERARD_STATUS_NO_SUCH = -5,
  /**
   * The caller's memory is too small. erard_action_save and erard_keyboard_save write the size that is needed.
   */
  ERARD_STATUS_SIZE = -6,
  /**
   * The bytes are damaged, or not a saved state of this version.
   */
  ERARD_STATUS_SAVED = -7,
  /**
   * The saved state belongs to another instrument, or to other settings: another step length, theta, solver or
   * friction.
   */
  ERARD_STATUS_FOREIGN = -8,
  /**
   * The file's text is invalid: erard_last_error says where.
   */
  ERARD_STATUS_FILE = -9,
  /**
   * The file is valid, but its instrument cannot be assembled, finds no rest, or cannot be measured or regulated.
   */
  ERARD_STATUS_MODEL = -10,
  /**
   * The caller's progress function stopped the work.
   */
  ERARD_STATUS_INTERRUPTED = -11,
  /**
   * An error inside this library. Only free the object or, if it is an action, reset or restore it.
   */
  ERARD_STATUS_INTERNAL = -12,
  /**
   * The first field of a struct does not hold the struct's size, or a field that this library does not know is not
   * 0.
   */
  ERARD_STATUS_STRUCT = -13,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ErardStatus ErardStatus;
#else
typedef int32_t ErardStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * One action under the caller's control. It belongs to the caller until erard_action_free. Any thread may use it, one
 * at a time.
 */
typedef struct ErardAction ErardAction;

/**
 * Keys with sensors, in memory of the caller. One thread at a time may use it. It must stay where it was made.
 */
typedef struct ErardBoard ErardBoard;

/**
 * Event detector: observes an action step by step and finds the events of one press. It belongs to the caller until
 * erard_event_detector_free.
 */
typedef struct ErardEventDetector ErardEventDetector;

/**
 * An instrument, with the text of the file that it was read from. It belongs to the caller until
 * erard_instrument_free. Only erard_instrument_set and erard_instrument_vary change it; several threads may read it at
 * once.
 */
typedef struct ErardInstrument ErardInstrument;

/**
 * A whole keyboard under the caller's control. It belongs to the caller until erard_keyboard_free. One thread at a
 * time may use it.
 */
typedef struct ErardKeyboard ErardKeyboard;

/**
 * A stroke over time, which drives actions of one instrument step by step. It belongs to the caller until
 * erard_stroke_free. One thread at a time may use it.
 */
typedef struct ErardStroke ErardStroke;

/**
 * Reading after a step. Positions are relative to rest; positions and velocities are those at the end of the step,
 * forces those that acted during it.
 */
typedef struct ErardReading {
  /**
   * sizeof(ErardReading).
   */
  uint32_t struct_size;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * The present instant, s from the action's creation or its last reset.
   */
  double time_s;
  /**
   * Travel of the key front, m, down positive.
   */
  double key_m;
  /**
   * Velocity of the key front, m/s, down positive.
   */
  double key_m_per_s;
  /**
   * Force of the finger on the key in the last step, N, down positive: the force that a haptic key renders.
   */
  double finger_force_n;
  /**
   * Mean finger force over all steps of the call that made this reading, N: for a device that is slower than the
   * steps.
   */
  double finger_force_mean_n;
  /**
   * Rise of the hammer's strike point, m, up positive.
   */
  double hammer_rise_m;
  /**
   * Upward velocity of the hammer's strike point, m/s.
   */
  double hammer_rise_m_per_s;
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
   * Position of the hand, m below the key front's rest. Without a hand, the last position of the last one.
   */
  double hand_m;
  /**
   * Velocity of the hand, m/s, down positive.
   */
  double hand_m_per_s;
} ErardReading;

/**
 * Input of a key. Fields that the kind does not use are ignored.
 */
typedef struct ErardInput {
  /**
   * sizeof(ErardInput).
   */
  uint32_t struct_size;
  /**
   * ERARD_INPUT_FREE, ERARD_INPUT_FORCE, ERARD_INPUT_MOTION, ERARD_INPUT_RIGID or ERARD_INPUT_HAND.
   */
  uint32_t kind;
  /**
   * Force on the key front, N, down positive. With ERARD_INPUT_HAND: force of the muscle on the hand.
   */
  double force_n;
  /**
   * Position, m below the key front's rest. With ERARD_INPUT_HAND: the position at which the muscle holds the hand.
   */
  double position_m;
  /**
   * Velocity, m/s, down positive. With ERARD_INPUT_HAND: the velocity toward which the muscle damps the hand.
   */
  double velocity_m_per_s;
  /**
   * Effective mass of the hand at the fingertip, kg, 0.001 to 100.
   */
  double hand_mass_kg;
  /**
   * Stiffness with which the muscle holds the hand at position_m, N/m, 0 to 1e7; 0 for none.
   */
  double muscle_n_per_m;
  /**
   * Damping of the muscle, N s/m, 0 to 1e5.
   */
  double muscle_n_s_per_m;
  /**
   * Compliance of the joints of the hand's finger, m/N, 0 to 0.1; 0 for stiff ones.
   */
  double joints_m_per_n;
  /**
   * Damping of the joints over their stiffness, s, 0 to 1.
   */
  double joints_s;
} ErardInput;

/**
 * Impact of a hammer on its string. In an array, set the size of the first element only: it holds for all.
 */
typedef struct ErardImpact {
  /**
   * sizeof(ErardImpact).
   */
  uint32_t struct_size;
  /**
   * The key, from 1.
   */
  uint32_t key;
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
 * What a board is made of. Zero is the usual choice of every field whose 0 says so.
 */
typedef struct ErardBoardSetup {
  /**
   * sizeof(ErardBoardSetup).
   */
  uint32_t struct_size;
  /**
   * The lowest key, from 1, the lowest A of a piano.
   */
  uint32_t first_key;
  /**
   * Number of keys, from the lowest on.
   */
  uint32_t key_count;
  /**
   * ERARD_BOARD_ACTION or ERARD_BOARD_LIGHT.
   */
  uint32_t kind;
  /**
   * ERARD_SENSOR_LINEAR, ERARD_SENSOR_CNY70 or ERARD_SENSOR_HALL; erard_board_sensor_table gives a law of your own.
   */
  uint32_t sensor_law;
  /**
   * Of a Hall sensor: 1 if sensor and magnet are nearest at the key's rest, 0 if at its bottom.
   */
  uint32_t nearest_at_rest;
  /**
   * ERARD_VELOCITY_USUAL, ERARD_VELOCITY_LOGARITHMIC or ERARD_VELOCITY_LINEAR; erard_board_velocity_table gives a
   * law of your own.
   */
  uint32_t velocity_law;
  /**
   * Bits of a velocity: 7, or 14 with a controller 88 before each note; 0 is 7.
   */
  uint32_t velocity_bits;
  /**
   * MIDI channel, 0 to 15.
   */
  uint32_t channel;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * Length of a step, s, 1 us to 1 ms. 0: 50 us; on a chip 250 us, in which every note is within one velocity of
   * that in 50 us.
   */
  double step_s;
  /**
   * Travel of the sensed place between the key's two stops, m, 0.5 mm to 100 mm.
   */
  double travel_m;
  /**
   * Distance of the sensed place from the balance pin, m, on either side; 0: at the key's front.
   */
  double sensor_at_m;
  /**
   * Of a Hall sensor: distance from the magnet where they are nearest, m, 0.1 mm to 100 mm.
   */
  double nearest_m;
  /**
   * A reading that differs from the last accepted one by no more than this counts as equal, so that noise does not
   * keep a resting key awake; 0: every change counts.
   */
  double still;
  /**
   * Velocity at 1 m/s, for ERARD_VELOCITY_LOGARITHMIC.
   */
  double velocity_at_one;
  /**
   * Velocities for twice the speed, positive, for ERARD_VELOCITY_LOGARITHMIC.
   */
  double velocity_per_octave;
  /**
   * The speed of velocity 127, m/s, positive, for ERARD_VELOCITY_LINEAR.
   */
  double velocity_full_m_per_s;
  /**
   * Upward speed of a key's front with which its note-off has velocity 64, m/s; 0: 0.2 m/s.
   */
  double release_m_per_s;
} ErardBoardSetup;

/**
 * Readings at a key's two stops. In an array, set the size of the first element only: it holds for all.
 */
typedef struct ErardStops {
  /**
   * sizeof(ErardStops).
   */
  uint32_t struct_size;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * The reading at rest.
   */
  double rest;
  /**
   * The reading with the key held at its bottom. If both readings are 0, the key has no sensor: its readings are
   * ignored.
   */
  double pressed;
  /**
   * Result of erard_board_calibrate: standard deviation of readings at rest, as a share of the range. Not read.
   */
  double noise;
  /**
   * Result of erard_board_calibrate: drift at rest from first to last reading, as a share of the range. Not read.
   */
  double drift;
} ErardStops;

/**
 * State of a board's key. Counts are of all readings since the board was made or reset.
 */
typedef struct ErardBoardKey {
  /**
   * sizeof(ErardBoardKey).
   */
  uint32_t struct_size;
  /**
   * 1 if its action is at a complete rest: it then takes no steps, whatever keys beside it do. Of contacts 1 if none
   * is closed and no note sounds, of hammers 1 if no note sounds.
   */
  uint32_t asleep;
  /**
   * Keystrokes that were limited so that no hammer goes faster than 8 m/s.
   */
  uint32_t limited_strokes;
  /**
   * Motions from the rest by less than 0.5 mm, which are noise.
   */
  uint32_t flutters;
  /**
   * Times that the sensor stayed still between up and down for 10 s.
   */
  uint32_t stuck;
  /**
   * Times that the drift exceeded 15 % of the sensor's range, up to which it is followed.
   */
  uint32_t drifts_beyond;
  /**
   * Messages of the whole board that found no room: 0, but for actions that no piano has.
   */
  uint32_t lost_messages;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * Readings deeper than the key goes.
   */
  double deep_readings;
  /**
   * Steps in which a number was not finite: the key stayed where it was.
   */
  double non_finite_steps;
  /**
   * The fastest hammer, m/s.
   */
  double fastest_hammer_m_per_s;
  /**
   * Present drift of the sensor's rest, as a share of its range.
   */
  double drift;
  /**
   * Contacts: changes that were bounces.
   */
  uint32_t bounces;
  /**
   * Contacts: times that the lowest one closed although none above it had closed since the last note.
   */
  uint32_t untimed_strokes;
  /**
   * Contacts: times that the key came to its lowest one too slowly to throw a hammer.
   */
  uint32_t slow_strokes;
  /**
   * Contacts: times that one closed after the one below it.
   */
  uint32_t swapped_contacts;
  /**
   * Contacts: times that they closed in less than half the time of the fastest press, as wires that touch do.
   */
  uint32_t fast_strokes;
  /**
   * Hammers: rises of 3 mm or more that turned before the string.
   */
  uint32_t lifts;
  /**
   * Hammers: the highest place of the head below its string, m.
   */
  double nearest_m;
} ErardBoardKey;

/**
 * The contacts of all keys of a board, and the hammer speeds by the time between them. It may be a constant.
 */
typedef struct ErardContacts {
  /**
   * sizeof(ErardContacts).
   */
  uint32_t struct_size;
  /**
   * Number of contacts of a key, 2 or 3.
   */
  uint32_t count;
  /**
   * The contact whose opening ends a note, from 1 for the upper one; never the lowest one.
   */
  uint32_t off;
  /**
   * Points of each table, 2 to 24: of the time from contact 1 to the lowest one, and of three contacts from contact
   * 2.
   */
  uint32_t point_count[2];
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * Depths of the key's front at which the contacts close, m, rising, 0.1 mm to 20 mm.
   */
  double depths_m[ERARD_MAX_CONTACTS];
  /**
   * Period of the scan, s; 0 for edges that interrupts report.
   */
  double scan_period_s;
  /**
   * How long after its time stamp each contact is read, s, within the period.
   */
  double scan_phases_s[ERARD_MAX_CONTACTS];
  /**
   * Changes of a contact within this time after an edge are bounces of it, s, 0 to 0.1.
   */
  double bounce_s;
  /**
   * The tables, a point each: time to the lowest contact, s, rising; hammer speed, m/s, falling, at most 8; time
   * from the lowest contact to the impact, s; error of touch, counts of velocity. The last two may be 0.
   */
  double points[2][ERARD_MAX_CONTACT_POINTS][4];
} ErardContacts;

/**
 * A second sensor of each hammer's key, at the key or the damper, which sees its release.
 */
typedef struct ErardRelease {
  /**
   * sizeof(ErardRelease).
   */
  uint32_t struct_size;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * Travel of the sensed place between its two stops, m, 0.5 mm to 100 mm, in proportion to the reading.
   */
  double travel_m;
  /**
   * Its travel at which, coming up, the damper lies on the string, m, within the travel.
   */
  double off_m;
} ErardRelease;

/**
 * Progress function, called repeatedly during long work with the share done, 0 to 1 (NaN where the share is not
 * known), and the caller's own pointer. If it returns 0, the work stops with ERARD_STATUS_INTERRUPTED.
 */
typedef int32_t (*ErardProgress)(double share, void *user);

/**
 * Events of one press. Times are s on the action's clock; events that have not happened are NaN.
 */
typedef struct ErardEvents {
  /**
   * sizeof(ErardEvents).
   */
  uint32_t struct_size;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * The key front is a tenth of a millimetre below its rest.
   */
  double key_start_s;
  /**
   * The jack's toe touches the let-off button.
   */
  double toe_contact_s;
  /**
   * The last push on the knuckle before the impact ends. Without an impact: the last push before the hammer's
   * highest point.
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
   * The key touches its front punching.
   */
  double key_bottom_s;
  /**
   * The hammer's tail touches the back check, after the impact.
   */
  double check_s;
  /**
   * Time from let-off to the impact, s.
   */
  double free_flight_s;
  /**
   * Time from the impact to the key's bottom, s; negative if the key reaches the bottom first.
   */
  double key_bottom_after_impact_s;
} ErardEvents;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Returns the version of this library, e.g. "0.1.0"; never NULL. Real time: yes.
 */
const char *erard_version(void);

/**
 * Returns the version of this interface: ERARD_ABI of the header that the library was built with. Real time: yes.
 */
uint32_t erard_abi(void);

/**
 * Returns the message of this thread's last failed call: one line of UTF-8, with line and key for a file; empty if no
 * call failed. Real-time functions return a status only and leave the message as it is. The text belongs to the
 * library and is valid until the next such call fails.
 */
const char *erard_last_error(void);

/**
 * Returns the meaning of a status as one line of English; never NULL. Real time: yes.
 */
const char *erard_status_text(int32_t status);

/**
 * Frees a text that the library returned. NULL does nothing. Real time: no.
 */
void erard_text_free(char *text);

/**
 * Allocates `bytes` bytes, set to zero, for callers that have no memory to pass, such as a web page. Returns NULL for
 * 0 bytes and when memory is exhausted. Free it with erard_memory_free. Real time: no.
 */
uint8_t *erard_memory_new(size_t bytes);

/**
 * Frees memory that erard_memory_new returned; `bytes` must be its size. NULL does nothing. Real time: no.
 */
void erard_memory_free(uint8_t *memory, size_t bytes);

/**
 * Makes an action at rest, with nothing touching its key, from the text of an instrument file (UTF-8, `length` bytes;
 * no terminating zero is needed). NULL and 0 give the built-in concert grand. `step_s` is the step length, s, 1e-8 to
 * 1e-3: usually 50e-6, or 1/24000 with modal strings, near which steps are halved as often as needed. Returns NULL on
 * failure: `status` (which may be NULL) receives the reason, and erard_last_error describes it. Real time: no (it
 * reads, allocates, and simulates until the action rests).
 */
struct ErardAction *erard_action_new(const char *text, size_t length, double step_s, ErardStatus *status);

/**
 * Makes an action at rest from an instrument, which may be freed afterwards. `step_s` and failures are as for
 * erard_action_new. Real time: no.
 */
struct ErardAction *erard_action_of_instrument(const struct ErardInstrument *instrument,
                                               double step_s,
                                               ErardStatus *status);

/**
 * Frees an action. NULL does nothing. Real time: no.
 */
void erard_action_free(struct ErardAction *action);

/**
 * Takes one step under a force on the key front, N, down positive (admittance: force in, position out). `reading` may
 * be NULL. An error leaves the action as it was. Real time: yes.
 */
ErardStatus erard_action_step_force(struct ErardAction *action, double force_n, struct ErardReading *reading);

/**
 * Takes one step under a device that is `position_m` below the key's rest and moves at `velocity_m_per_s`, down
 * positive, both in the middle of the step (impedance: position in, force out, as finger_force_n of the reading). The
 * fingertip of the instrument's file couples device and key: a spring and a damper that only push (virtual coupling).
 * `reading` may be NULL. An error leaves the action as it was. Real time: yes.
 */
ErardStatus erard_action_step_motion(struct ErardAction *action,
                                     double position_m,
                                     double velocity_m_per_s,
                                     struct ErardReading *reading);

/**
 * Takes one step under a pointer of the caller's that is `position_m` below the key's rest and moves at
 * `velocity_m_per_s`, down positive, behind a fingertip of the caller's own, `stiffness_n_per_m` (0 to 1e6) and
 * `damping_n_s_per_m` (0 to 1e3), which only pushes. Its force is that of the key's last reading, held over the step,
 * so that the instrument stays as its file has it: the fingertip of a mouse or a story may be softer than the file's.
 * For a device with forces of its own erard_action_step_motion is better, whose coupling the step solves for.
 * `reading` may be NULL. An error leaves the action as it was. Real time: yes.
 */
ErardStatus erard_action_step_fingertip(struct ErardAction *action,
                                        double position_m,
                                        double velocity_m_per_s,
                                        double stiffness_n_per_m,
                                        double damping_n_s_per_m,
                                        struct ErardReading *reading);

/**
 * Takes one step with prescribed motion of the key front: its position, m below rest, and velocity, m/s, down
 * positive, at the end of the step. Use it for measured strokes, not in a loop with a device (README, "Closed loop").
 * `reading` may be NULL. An error leaves the action as it was. Real time: yes.
 */
ErardStatus erard_action_step_rigid(struct ErardAction *action,
                                    double position_m,
                                    double velocity_m_per_s,
                                    struct ErardReading *reading);

/**
 * Takes one step with nothing touching the key. `reading` may be NULL. An error leaves the action as it was. Real
 * time: yes.
 */
ErardStatus erard_action_step_free(struct ErardAction *action, struct ErardReading *reading);

/**
 * Takes one step under an input of any kind, including a hand. `reading` may be NULL. An error leaves the action as it
 * was. Real time: yes.
 */
ErardStatus erard_action_step_input(struct ErardAction *action,
                                    const struct ErardInput *input,
                                    struct ErardReading *reading);

/**
 * Places the hand (ERARD_INPUT_HAND): `position_m` is m below the key front's rest, `velocity_m_per_s` m/s, down
 * positive. In a new action the hand is at the key front's rest. Only steps with ERARD_INPUT_HAND move it. Real time:
 * yes.
 */
ErardStatus erard_action_place_hand(struct ErardAction *action, double position_m, double velocity_m_per_s);

/**
 * Takes as many steps as fit into `dt_s` (s, 0 to ERARD_MAX_ADVANCE_S), for a device that is slower than the steps.
 * The remaining time is added to the next call, so periods of any length do not drift. The input is that at the
 * beginning of `dt_s`: a force is held, a position continues at its velocity. Render finger_force_mean_n of the
 * reading: held over `dt_s`, it has the same impulse as the steps. If a step fails, the action is left as it was
 * before the call. Real time: yes; the call takes as long as its steps.
 */
ErardStatus erard_action_advance(struct ErardAction *action,
                                 double dt_s,
                                 const struct ErardInput *input,
                                 struct ErardReading *reading);

/**
 * Writes the present reading of the action to `reading`; after a step, it is the reading that the step wrote. Real
 * time: yes.
 */
ErardStatus erard_action_read(const struct ErardAction *action, struct ErardReading *reading);

/**
 * Returns the action to its state when it was made: at rest, at 0 s, with no impact counted. Real time: yes.
 */
ErardStatus erard_action_reset(struct ErardAction *action);

/**
 * Writes the action's complete state to `bytes`. A restored action continues with the same bits. `size` holds the room
 * in `bytes` and receives the number of bytes needed: about 2.8 kB, and 16 bytes more for each mode of modal strings.
 * Actions with rigid strings all need the same size. If the room is too small, nothing is written and the call returns
 * ERARD_STATUS_SIZE. If `bytes` is NULL, only the size is reported. The state is a set of named lists of numbers: an
 * earlier library skips the lists that a later one adds, and a later one does without those that an earlier one lacks.
 * The bytes are the same on every machine. Real time: yes.
 */
ErardStatus erard_action_save(const struct ErardAction *action, uint8_t *bytes, size_t *size);

/**
 * Sets the target lift of the sustain pedal's rail, m, 0 to 0.010; values outside are clamped. The rail moves there at
 * no more than 0.5 m/s. Without modal strings or without a rail, the call does nothing. Real time: yes.
 */
ErardStatus erard_action_set_pedal(struct ErardAction *action, double lift_m);

/**
 * Writes the present force of the strings on the bridge, N, to `force_n`, positive in the direction in which the
 * hammer pushes the strings; 0 without modal strings. `erard press --wav` writes this force less its value at rest as
 * sound. Real time: yes.
 */
ErardStatus erard_action_bridge_force(const struct ErardAction *action, double *force_n);

/**
 * Writes what is heard of an action after its last step to `pressure_pa[2]`: the sound pressure at two places 1 m
 * before the soundboard and half a metre apart, Pa; of the strings, and of the knocks of key, rails and damper on the
 * key bed. An estimate, without a room; `erard press --wav` writes it. Call it once after every step: each call ends a
 * sample. Returns ERARD_STATUS_NO_SUCH where strings move no soundboard. Real time: yes.
 */
ErardStatus erard_action_pressure(struct ErardAction *action, double *pressure_pa);

/**
 * Writes the positions at which erard_action_string_shape samples the middle string to `places_m` (which may be NULL),
 * at most `count` of them: m from the striking point, positive away from the string's nearer end. Returns the number
 * of positions; 0 without modal strings and for NULL. Real time: yes.
 */
size_t erard_action_string_places(const struct ErardAction *action, double *places_m, size_t count);

/**
 * Writes the displacement of the middle string from its rest at each position of erard_action_string_places, m,
 * positive away from the hammer. `count` is the room in `shape_m`, at least the number of positions, else the call
 * returns ERARD_STATUS_SIZE. Without modal strings, the call writes nothing. Real time: yes.
 */
ErardStatus erard_action_string_shape(const struct ErardAction *action, float *shape_m, size_t count);

/**
 * Restores a saved state. The instrument must have the same numbers (name, notes and order in the file may differ) and
 * the action the same step length. The action then continues with the same bits, and its reading is the saved one. An
 * error (ERARD_STATUS_SAVED, ERARD_STATUS_FOREIGN or ERARD_STATUS_NOT_FINITE) leaves the action as it was. Real time:
 * yes.
 */
ErardStatus erard_action_restore(struct ErardAction *action, const uint8_t *bytes, size_t size);

/**
 * Returns the number of bodies of an action; 0 for NULL. Real time: yes.
 */
size_t erard_action_body_count(const struct ErardAction *action);

/**
 * Returns the number of contact zones of an action; 0 for NULL. Real time: yes.
 */
size_t erard_action_zone_count(const struct ErardAction *action);

/**
 * Returns the name of a body as the instrument file gives it; `body` counts from 0. Returns NULL if there is no such
 * body. The text belongs to the action and is valid as long as the action. Real time: yes.
 */
const char *erard_action_body_name(const struct ErardAction *action, size_t body);

/**
 * Returns the name of a contact zone; `zone` counts from 0. Otherwise as erard_action_body_name. Real time: yes.
 */
const char *erard_action_zone_name(const struct ErardAction *action, size_t zone);

/**
 * Writes the absolute angles of all bodies, rad, to `angles_rad`: positive counter-clockwise, seen with the player on
 * the left. `count` is the room in `angles_rad`, at least erard_action_body_count, else the call returns
 * ERARD_STATUS_SIZE. Real time: yes.
 */
ErardStatus erard_action_angles(const struct ErardAction *action, double *angles_rad, size_t count);

/**
 * Writes the absolute angular velocities of all bodies, rad/s, to `velocities_rad_per_s`. Sign and `count` are as for
 * erard_action_angles. Real time: yes.
 */
ErardStatus erard_action_velocities(const struct ErardAction *action, double *velocities_rad_per_s, size_t count);

/**
 * Writes the normal forces of all contact zones in the last step, N, never negative, to `forces_n`. `count` is the
 * room in `forces_n`, at least erard_action_zone_count, else the call returns ERARD_STATUS_SIZE. After a restore or a
 * reset the forces are 0 until the next step. Real time: yes.
 */
ErardStatus erard_action_contact_forces(const struct ErardAction *action, double *forces_n, size_t count);

/**
 * Makes 88 keys at rest from the text of a keyboard file (UTF-8, `length` bytes) whose base instrument is built in.
 * NULL and 0 give the built-in concert grand. `step_s` is the step length, s, as for erard_action_new. Each key keeps
 * its input until you change it; at first it is ERARD_INPUT_FREE. Returns NULL on failure: `status` (which may be
 * NULL) receives the reason, and erard_last_error describes it. Real time: no (it takes about half a second).
 */
struct ErardKeyboard *erard_keyboard_new(const char *text, size_t length, double step_s, ErardStatus *status);

/**
 * Makes 88 keys at rest from a built-in keyboard, by its name: `concert-grand`, or `concert-grand-strings` with modal
 * strings. `step_s` is the step length, s. Returns NULL on failure, with ERARD_STATUS_NO_SUCH for an unknown name;
 * otherwise as erard_keyboard_new. Real time: no.
 */
struct ErardKeyboard *erard_keyboard_builtin(const char *called, double step_s, ErardStatus *status);

/**
 * Frees a keyboard. NULL does nothing. Real time: no.
 */
void erard_keyboard_free(struct ErardKeyboard *keyboard);

/**
 * Returns the number of keys; 0 for NULL. Keys count from 1, the lowest A. Real time: yes.
 */
uint32_t erard_keyboard_key_count(const struct ErardKeyboard *keyboard);

/**
 * Returns the number of keys that are awake, which are those that take computing time; 0 for NULL. Real time: yes.
 */
uint32_t erard_keyboard_awake_count(const struct ErardKeyboard *keyboard);

/**
 * Sets the input of a key from the next step on; `key` counts from 1. The position of ERARD_INPUT_MOTION stays
 * constant, whatever its velocity: set the input again whenever the position changes. Returns ERARD_STATUS_NO_SUCH if
 * there is no such key. Real time: yes.
 */
ErardStatus erard_keyboard_drive(struct ErardKeyboard *keyboard, uint32_t key, const struct ErardInput *input);

/**
 * Places the hand (ERARD_INPUT_HAND) on a key, as erard_action_place_hand does; `key` counts from 1. Real time: yes.
 */
ErardStatus erard_keyboard_place_hand(struct ErardKeyboard *keyboard,
                                      uint32_t key,
                                      double position_m,
                                      double velocity_m_per_s);

/**
 * Sets the target lift of the sustain pedal's rail, m, under all keys that have one, as erard_action_set_pedal does.
 * Real time: yes.
 */
ErardStatus erard_keyboard_set_pedal(struct ErardKeyboard *keyboard, double lift_m);

/**
 * Writes the present force of a key's strings on the bridge, N, to `force_n`, as erard_action_bridge_force does; `key`
 * counts from 1. Real time: yes.
 */
ErardStatus erard_keyboard_bridge_force(const struct ErardKeyboard *keyboard, uint32_t key, double *force_n);

/**
 * Writes the present force of all keys' strings on the bridge, N, to `force_n`, including the load of the dampers at
 * rest; 0 without modal strings. Real time: yes.
 */
ErardStatus erard_keyboard_total_bridge_force(const struct ErardKeyboard *keyboard, double *force_n);

/**
 * Writes what is heard of all keys after the last step to `pressure_pa[2]`, as erard_action_pressure does; they share
 * one key bed. Call it once after every step: each call ends a sample. Returns ERARD_STATUS_NO_SUCH where strings move
 * no soundboard. Real time: yes.
 */
ErardStatus erard_keyboard_pressure(struct ErardKeyboard *keyboard, double *pressure_pa);

/**
 * Takes `steps` steps (1 to ERARD_MAX_STEPS) of all keys that are awake. Writes the impacts in the order of the steps
 * to `impacts`, at most `capacity` of them. `count` (which may be NULL) receives the number of impacts; those beyond
 * `capacity` are lost. If a key's numbers become infinite, that key stays as it was, the other keys continue, and the
 * call returns ERARD_STATUS_NOT_FINITE. Real time: yes.
 */
ErardStatus erard_keyboard_step(struct ErardKeyboard *keyboard,
                                uint32_t steps,
                                struct ErardImpact *impacts,
                                size_t capacity,
                                size_t *count);

/**
 * Writes the reading of a key after the last step to `reading`; `key` counts from 1. finger_force_mean_n is the force
 * of the last step; new_impact_count is 0. Real time: yes.
 */
ErardStatus erard_keyboard_read(const struct ErardKeyboard *keyboard, uint32_t key, struct ErardReading *reading);

/**
 * Writes the absolute angles of a key's bodies, rad, to `angles_rad`, in the order of the bodies in its instrument, as
 * erard_action_angles does for one action. `key` counts from 1; `count` is the room in `angles_rad`. Real time: yes.
 */
ErardStatus erard_keyboard_angles(const struct ErardKeyboard *keyboard, uint32_t key, double *angles_rad, size_t count);

/**
 * Writes the keyboard's complete state, including inputs and time, to `bytes`, as erard_action_save does (about 220
 * kB). Real time: yes.
 */
ErardStatus erard_keyboard_save(const struct ErardKeyboard *keyboard, uint8_t *bytes, size_t *size);

/**
 * Restores a saved state of the same keyboard with the same step length. Every key then continues with the same bits;
 * times agree to rounding. An error leaves the keyboard as it was. Forces read 0 until the next step. Real time: yes.
 */
ErardStatus erard_keyboard_restore(struct ErardKeyboard *keyboard, const uint8_t *bytes, size_t size);

/**
 * Chooses how often an action's steps are halved while its hammer is near modal strings, from the next step on:
 * ERARD_HALVING_AUTO (the default), ERARD_HALVING_FEWER or ERARD_HALVING_NEVER, else the call returns
 * ERARD_STATUS_ARGUMENT. Saved states do not contain this choice: set it again after making an action. Without modal
 * strings it changes nothing. Real time: no (it may allocate); call it before the loop.
 */
ErardStatus erard_action_set_halving(struct ErardAction *action, uint32_t kind);

/**
 * Chooses the halving of steps for all keys of a keyboard, as erard_action_set_halving does. Keys that are played wake
 * all others; at rest all sleep on. Real time: no.
 */
ErardStatus erard_keyboard_set_halving(struct ErardKeyboard *keyboard, uint32_t kind);

/**
 * Returns the number of bytes that a board of so many keys takes; 0 for no key or more than 88. Real time: yes.
 */
size_t erard_board_bytes(uint32_t key_count);

/**
 * Returns the alignment of a board's memory, bytes: memory of malloc has it, and so has an array of double on every
 * usual machine. Real time: yes.
 */
size_t erard_board_alignment(void);

/**
 * Makes a board in `memory` of `bytes` bytes (erard_board_bytes, erard_board_alignment), which stays the caller's
 * and must not move. `stops` has an element for each key of the setup. `keyboard` is the text of a keyboard file
 * (UTF-8, `length` bytes) whose base instrument is built in; NULL and 0 give the built-in concert grand, the only
 * one on a chip, where all keys have the action of its middle C. Each key is pressed some times to find its
 * limits, which takes a tenth of a second a key, on all cores; and its action takes memory, which erard_board_free
 * gives back. On a chip both are prepared. Returns the board, or NULL on failure: `status` (which may be NULL)
 * receives the reason, and erard_last_error describes it. Real time: no.
 */
struct ErardBoard *erard_board_new(void *memory,
                                   size_t bytes,
                                   const struct ErardBoardSetup *setup,
                                   const struct ErardStops *stops,
                                   const char *keyboard,
                                   size_t length,
                                   ErardStatus *status);

/**
 * Gives back what the function that made the board took beside the caller's memory, which may then be used otherwise.
 * NULL does nothing. Real time: no.
 */
void erard_board_free(struct ErardBoard *board);

/**
 * Gives the sensors of all keys a law of your own: `count` points, at least two, each the share of a reading's range
 * and the share of the travel, both from 0 to 1, ascending. The points are not copied: they must last as long as the
 * board, in flash, say. Call it before the first scan. Of hammers it is the law of their heads' sensors. Returns
 * ERARD_STATUS_ARGUMENT for points that do not rise from {0, 0} to {1, 1}, and for a board of contacts. Real time:
 * yes.
 */
ErardStatus erard_board_sensor_table(struct ErardBoard *board, const double (*points)[2], size_t count);

/**
 * Gives the board a velocity law of your own: `count` points, at least two, each a hammer speed, m/s, and a velocity,
 * 0 to 127, both ascending; straight lines between them in velocity and the logarithm of the speed. The points are not
 * copied: they must last as long as the board. Returns ERARD_STATUS_ARGUMENT for points that do not rise. Real time:
 * yes.
 */
ErardStatus erard_board_velocity_table(struct ErardBoard *board, const double (*points)[2], size_t count);

/**
 * Takes the readings of all keys at an instant, s on the scanner's clock: `count` readings, one for each key of the
 * setup. Writes the resulting MIDI bytes, whole messages, to `midi`, which must have room for ERARD_BOARD_KEY_BYTES
 * for each key, and their number to `length`. A note-on is written once its hammer has met the string, a note-off once
 * the key, coming up, has set its damper down. After a gap of more than a second held notes end first, and nothing is
 * simulated for it. Of hammers they are the readings of their heads. Returns ERARD_STATUS_RANGE for an instant that is
 * not after the last one, ERARD_STATUS_NOT_FINITE for a reading that is no number, and ERARD_STATUS_ARGUMENT for a
 * board of contacts. Real time: yes; the work is that of the time since the last scan for the keys that move, and
 * nearly none for those at rest.
 */
ErardStatus erard_board_scan(struct ErardBoard *board,
                             double time_s,
                             const float *readings,
                             size_t count,
                             uint8_t *midi,
                             size_t room,
                             size_t *length);

/**
 * Takes the position of a pedal, 0 (up) to 1 (down), by its controller: 64 sustain, 66 sostenuto, 67 soft. Writes a
 * controller's message to `midi`, which must have room for three bytes, if its value has changed, and the number of
 * bytes to `length`. Returns ERARD_STATUS_ARGUMENT for another controller. Real time: yes.
 */
ErardStatus erard_board_pedal(struct ErardBoard *board,
                              uint32_t controller,
                              double down,
                              uint8_t *midi,
                              size_t room,
                              size_t *length);

/**
 * Lets all keys go, whatever their sensors read, follows them to their rest, and lets the pedals up: no note is left.
 * For the end, or a scanner that has stalled. Writes to `midi` and `length` as erard_board_scan does. Real time: yes;
 * up to a second of every key that is not at rest is simulated.
 */
ErardStatus erard_board_let_go(struct ErardBoard *board, uint8_t *midi, size_t room, size_t *length);

/**
 * Puts a board back to where it was made, its laws as they are: keys at rest, no drift, nothing counted, a new clock,
 * pedals up. Nothing is sent. Real time: yes.
 */
ErardStatus erard_board_reset(struct ErardBoard *board);

/**
 * Writes the state of a key to `state`; `key` counts from 1, the lowest A of a piano. Returns ERARD_STATUS_NO_SUCH for
 * a key that is not one of the board's, or has no sensor. Real time: yes.
 */
ErardStatus erard_board_read(struct ErardBoard *board, uint32_t key, struct ErardBoardKey *state);

/**
 * Finds the stops of a key in `count` of its readings, `period_s` apart: the key was left at rest for half a second,
 * pressed to its bottom, held there, and let go, as often as you like, as for `erard calibrate`. Writes them to
 * `stops`. `key` is named in messages only. On failure returns ERARD_STATUS_ARGUMENT, and erard_last_error says why:
 * too few readings, a reading that never changes, a range too small for its noise, a key that was never held. Real
 * time: no, but nothing is allocated: a chip can call it, too (a second for ten seconds of readings).
 */
ErardStatus erard_board_calibrate(uint32_t key,
                                  const float *readings,
                                  size_t count,
                                  double period_s,
                                  struct ErardStops *stops);

/**
 * Returns the number of bytes that a board of so many keys with contacts takes; 0 for no key or more than 88. Real
 * time: yes.
 */
size_t erard_board_contacts_bytes(uint32_t key_count);

/**
 * Makes a board of keys with contacts in `memory` of `bytes` bytes (erard_board_contacts_bytes,
 * erard_board_alignment), which stays the caller's and must not move. Of the setup it takes the keys, the channel and
 * the laws of velocities; all else must be 0. `contacts` is read during the call. Nothing is simulated: the tables are
 * those of `contacts`. Returns the board, or NULL on failure: `status` (which may be NULL) receives the reason, and
 * erard_last_error describes it. Real time: no, but nothing is allocated.
 */
struct ErardBoard *erard_board_contacts_new(void *memory,
                                            size_t bytes,
                                            const struct ErardBoardSetup *setup,
                                            const struct ErardContacts *contacts,
                                            ErardStatus *status);

/**
 * Takes an edge of a contact at an instant, s on the scanner's clock: `key` counts from 1, the lowest A of a piano,
 * `contact` from 1, the upper one; `is_made` is 1 as it closes, 0 as it opens. Bounces may be given, too. Writes the
 * resulting MIDI bytes, whole messages, to `midi`, which must have room for ERARD_BOARD_KEY_BYTES for each key, and
 * their number to `length`. A note-on is written as the lowest contact closes, before the hammer meets its string.
 * Returns ERARD_STATUS_NO_SUCH for a key or contact that the board does not have, ERARD_STATUS_RANGE for an instant
 * before the last one, and ERARD_STATUS_ARGUMENT for a board without contacts. Real time: yes.
 */
ErardStatus erard_board_edge(struct ErardBoard *board,
                             double time_s,
                             uint32_t key,
                             uint32_t contact,
                             uint32_t is_made,
                             uint8_t *midi,
                             size_t room,
                             size_t *length);

/**
 * Goes on to an instant, s on the scanner's clock, at which no contact has changed: one that stayed changed after its
 * bounces has changed. Call it in every scan without an edge; the next edge of any key does the same. Writes to `midi`
 * and `length` as erard_board_edge does, and returns what that returns. Real time: yes.
 */
ErardStatus erard_board_until(struct ErardBoard *board, double time_s, uint8_t *midi, size_t room, size_t *length);

/**
 * Fills the tables of contacts, and which of them ends a note, by a simulated action, as `erard calibrate --contacts`
 * does: reads `count`, `depths_m` and the scan's numbers of `contacts`, and writes `off`, `point_count` and `points`.
 * Middle C of a keyboard is pressed, struck and re-struck, which takes some seconds. `keyboard` is the text of a
 * keyboard file (UTF-8, `length` bytes) whose base instrument is built in; NULL and 0 give the built-in concert grand.
 * Where two or three contacts lie too near to each other, or below the key's dip, it returns ERARD_STATUS_RANGE. Not
 * on a chip: a program there has the result as a constant. Real time: no.
 */
ErardStatus erard_contacts_simulate(struct ErardContacts *contacts, const char *keyboard, size_t length);

/**
 * Returns the number of bytes that a board of so many sensed hammers takes; 0 for none or more than 88. Real time:
 * yes.
 */
size_t erard_board_hammers_bytes(uint32_t key_count);

/**
 * Makes a board whose sensors read the shanks of hammers, in `memory` of `bytes` bytes (erard_board_hammers_bytes,
 * erard_board_alignment), which stays the caller's and must not move. `setup.travel_m` is the way of a head on its arc
 * from its rest to its string; `kind`, `step_s`, `sensor_at_m` and `still` must be 0. `stops` has an element for each
 * key: its `rest` is the reading of the hammer at rest, its `pressed` that of the hammer held against its string.
 * `release` and `release_stops` describe the second sensors, whose stops are 0 for a key that has none; without them,
 * both NULL, a note ends when its head has fallen to a quarter of its way, with velocity 64. Nothing is simulated.
 * Returns the board, or NULL on failure: `status` (which may be NULL) receives the reason, and erard_last_error
 * describes it. Real time: no, but nothing is allocated.
 */
struct ErardBoard *erard_board_hammers_new(void *memory,
                                           size_t bytes,
                                           const struct ErardBoardSetup *setup,
                                           const struct ErardStops *stops,
                                           const struct ErardRelease *release,
                                           const struct ErardStops *release_stops,
                                           ErardStatus *status);

/**
 * Takes the readings of all hammers' heads and, unless `releases` is NULL, of the second sensors, at an instant, s on
 * the scanner's clock: `count` readings each, one for each key of the setup. Otherwise as erard_board_scan. A note-on
 * is written when the next reading would come after the impact. Returns ERARD_STATUS_ARGUMENT for a board of others
 * than hammers. Real time: yes.
 */
ErardStatus erard_board_scan_hammers(struct ErardBoard *board,
                                     double time_s,
                                     const float *heads,
                                     const float *releases,
                                     size_t count,
                                     uint8_t *midi,
                                     size_t room,
                                     size_t *length);

/**
 * Reads an instrument from the text of its file (UTF-8, `length` bytes). NULL and 0 give the built-in concert grand.
 * Returns NULL on failure: `status` (which may be NULL) receives the reason, and erard_last_error describes it;
 * erard_file_check reports the error as JSON. Real time: no, like all functions of instruments.
 */
struct ErardInstrument *erard_instrument_new(const char *text, size_t length, ErardStatus *status);

/**
 * Reads a built-in instrument by its name, e.g. "heavy-touch"; erard_builtin_names lists the names. Returns NULL on
 * failure, with ERARD_STATUS_NO_SUCH for an unknown name.
 */
struct ErardInstrument *erard_instrument_builtin(const char *called, ErardStatus *status);

/**
 * Reads the instrument of a key, 1 to 88, of the built-in keyboard `concert-grand`. Returns NULL on failure, with
 * ERARD_STATUS_NO_SUCH if there is no such key.
 */
struct ErardInstrument *erard_instrument_of_key(uint32_t key, ErardStatus *status);

/**
 * Reads the instrument of a key, 1 to 88, of a built-in keyboard by the keyboard's name, e.g. "concert-grand-strings";
 * erard_builtin_names lists the names. Returns NULL on failure, with ERARD_STATUS_NO_SUCH if there is no such keyboard
 * or key.
 */
struct ErardInstrument *erard_instrument_of_keyboard(const char *called, uint32_t key, ErardStatus *status);

/**
 * Returns the number of a piano's key, 1 to 88, from its note or its number as text: "C4", "c#4", "Db4", "40". Returns
 * 0 on failure, with ERARD_STATUS_NO_SUCH for a text that names none of the 88.
 */
uint32_t erard_key_number(const char *called, ErardStatus *status);

/**
 * Frees an instrument. NULL does nothing. Actions that were made from it remain valid.
 */
void erard_instrument_free(struct ErardInstrument *instrument);

/**
 * Returns the present text of the instrument's file. `length` (which may be NULL) receives its number of bytes.
 * Returns NULL on failure. Free the text with erard_text_free.
 */
char *erard_instrument_text(const struct ErardInstrument *instrument, size_t *length, ErardStatus *status);

/**
 * Writes one parameter of the file to `value`, in the file's own unit. `path` is its dotted path, with entries of a
 * list by their name: "body.hammer.mass_g", "zone.string.felt.exponent", "screw.let_off.setting_mm". `which` is 0, or
 * 0 or 1 for a coordinate. Returns ERARD_STATUS_NO_SUCH if there is no such parameter.
 */
ErardStatus erard_instrument_get(const struct ErardInstrument *instrument,
                                 const char *path,
                                 size_t which,
                                 double *value);

/**
 * Changes one parameter of the file, in the file's own unit; `path` and `which` are as for erard_instrument_get. The
 * changed text is read anew. An error, such as ERARD_STATUS_FILE for a value that the file may not have, leaves the
 * instrument as it was. Actions made from it earlier do not change.
 */
ErardStatus erard_instrument_set(struct ErardInstrument *instrument, const char *path, size_t which, double value);

/**
 * Returns the instrument as JSON: name, key (1 to 88) and sample (null where not known), description, gravity_m_s2,
 * bodies, zones and screws by name, and its parameters with path, values, line and source. Returns NULL on failure.
 * Free the text with erard_text_free.
 */
char *erard_instrument_json(const struct ErardInstrument *instrument, size_t *length, ErardStatus *status);

/**
 * Checks the text of an instrument or keyboard file (`length` bytes) and returns the result as JSON: {"kind", "sound",
 * "name", "errors"}. Each error has "line" and "column" (from 1), "key", "message", "found", "expected", its bytes
 * from "begin" up to "end" (exclusive), and "text", which says all of it in one line. The reader stops at the first
 * error. Text that is not UTF-8 is reported as an error, too. Returns NULL on failure, such as a NULL text. Free the
 * JSON with erard_text_free.
 */
char *erard_file_check(const char *text, size_t length, size_t *json_length, ErardStatus *status);

/**
 * Returns the names of the built-in instruments and keyboards as JSON: {"instruments": [...], "keyboards": [...]}.
 * Free the text with erard_text_free.
 */
char *erard_builtin_names(size_t *length, ErardStatus *status);

/**
 * Changes one quantity by its common name, as the command's option `--vary` does. `called` is "body.hammer.mass" (a
 * body's mass and, in proportion, its inertia), "let_off", "zone.check.friction", or the path of a parameter. `change`
 * is "8.7 g" (a value), "+0.8 g" or "-0.2 mm" (a difference), "x1.5" (a factor) or "=-0.2 mm" (a value with a sign). A
 * number without a unit is in SI units, or in the unit at the end of a path; it is never a factor. The new values are
 * written into the file's text, to ten digits, and the text is read anew. Errors: ERARD_STATUS_NO_SUCH (unknown name,
 * or one that does nothing in this instrument), ERARD_STATUS_ARGUMENT (the change cannot be read), ERARD_STATUS_RANGE
 * (the change is too large) and ERARD_STATUS_FILE (the file may not have this value); erard_last_error says what is
 * expected. An error leaves the instrument as it was. Actions made from it earlier do not change.
 */
ErardStatus erard_instrument_vary(struct ErardInstrument *instrument, const char *called, const char *change);

/**
 * Changes one quantity as erard_instrument_vary does, for a field in which a person types: a number without a unit is
 * in the unit in which technicians read the quantity (mm, g, degrees, N mm; else in SI units, or in the unit at the
 * end of a path), as in the command's option `--vary`. Errors are those of erard_instrument_vary.
 */
ErardStatus erard_instrument_vary_field(struct ErardInstrument *instrument, const char *called, const char *change);

/**
 * Returns a drawing of the instrument in one pose as SVG, as the command draws it. `angles_rad` holds `count` absolute
 * angles of its bodies, rad, as erard_action_angles writes them; NULL and 0 draw the pose of its file. `size_px` is
 * the longer side, 16 to 16384 px. `labels` is 1 to name the parts. Elements of a moving part have the attribute
 * `data-body`, the body's number. Returns NULL on failure. Free the text with erard_text_free.
 */
char *erard_instrument_draw(const struct ErardInstrument *instrument,
                            const double *angles_rad,
                            size_t count,
                            double size_px,
                            uint32_t labels,
                            size_t *length,
                            ErardStatus *status);

/**
 * Measures an instrument as a technician does, from where it rests after a moderate blow, and returns JSON. If
 * `wanted` is NULL, the JSON is the whole sheet, as `erard measure --json` writes it for an instrument. Otherwise
 * `wanted` names lines of the sheet, separated by commas ("down_weight_g,dip_mm"); the JSON is an object of their
 * values, and only these are measured. `key` is the piano key whose usual ranges hold, 1 to 88 (erard_key_number reads
 * notes); 0 is the instrument's own, or C4 where it does not know its key. `progress` may be NULL; with `wanted` its
 * share is NaN. Takes tenths of a second to seconds. Returns NULL on failure, with ERARD_STATUS_NO_SUCH for an unknown
 * line or key and ERARD_STATUS_ARGUMENT for a key other than the instrument's own. Free the text with erard_text_free.
 */
char *erard_instrument_measure(const struct ErardInstrument *instrument,
                               uint32_t key,
                               const char *wanted,
                               ErardProgress progress,
                               void *user,
                               size_t *length,
                               ErardStatus *status);

/**
 * Turns an instrument's screws until its action meets goals and returns JSON: the outcome of every goal, the screws
 * that were turned, all distances before and after (the fields of the report that `erard regulate` writes), and
 * "file", the text of the instrument file with its new settings. The instrument itself does not change. If `goals` is
 * NULL, what is out of its usual range is set to the trade's norm, and all else stays as it is. Otherwise it is a JSON
 * object of goals by name, with values in mm (`repetition spring` in mm/s, `damper start` in %) or texts with units:
 * {"let-off": 1.5, "blow": "1.8in"}. `progress` may be NULL. Takes seconds. Returns NULL on failure. Free the text
 * with erard_text_free.
 */
char *erard_instrument_regulate(const struct ErardInstrument *instrument,
                                const char *goals,
                                ErardProgress progress,
                                void *user,
                                size_t *length,
                                ErardStatus *status);

/**
 * Returns a drawing of an instrument as JSON, for a page that animates it. "shapes" and "gradients" are SVG for a g
 * and a defs element; moving elements have the attribute `data-body`, those on the pedal's rail `data-rail`. "bodies"
 * have their hinges, drawn angles and masses; "zones" the direction of their arrows. "press", "pedal" (whether there
 * is one), "string" (its striking point and height; null for a rigid string), "labels", "views" and the scale of the
 * arrows follow. Lengths are mm of the picture. Returns NULL on failure. Free the text with erard_text_free.
 */
char *erard_instrument_drawing_json(const struct ErardInstrument *instrument, size_t *length, ErardStatus *status);

/**
 * Returns the lines of the protocol sheet as JSON: groups of "heading" and "lines". Each line has "key" (its name in
 * erard_instrument_measure), "label", "unit", "decimals", and its norm at a piano key, 1 to 88: "usual" ([low, high];
 * null where open) and "source". Returns NULL if there is no such piano key. Free the text with erard_text_free.
 */
char *erard_sheet_lines(uint32_t key, size_t *length, ErardStatus *status);

/**
 * Diagnoses a key of a real piano from its measured readings and returns JSON, as `erard diagnose` writes it to
 * diagnosis.json: readings, causes, remedies and what to measure next. `readings` is a JSON object: "key" (1 to 88, or
 * a note; without it C4 is assumed and "is_key_assumed" is true), "leads" ("14@165, 14@147"), and readings by the
 * names of erard_diagnose_quantities, as numbers (in the unit at the end of the name) or as texts with units.
 * "balance_weight_g" and "friction_weight_g" may replace down-weight and up-weight. Takes up to seconds. Returns NULL
 * on failure; erard_last_error lists all errors in the readings. Free the text with erard_text_free.
 */
char *erard_diagnose(const char *readings, size_t *length, ErardStatus *status);

/**
 * Returns all errors in readings for erard_diagnose as JSON: an array of "name" (the reading's name, "key" or "leads";
 * empty if the error belongs to none of them), "found" and "expected". The array is empty if the readings are valid.
 * Free the text with erard_text_free.
 */
char *erard_diagnose_check(const char *readings, size_t *length, ErardStatus *status);

/**
 * Returns the quantities that can be measured on a real piano's key as JSON: an array of "name" (for erard_diagnose),
 * "label", "unit", "decimals", "limits", "precision", "usual" ([low, high] at that key, 1 to 88; null where open or
 * not applicable to this key) and "how" to measure it. Returns NULL if there is no such key. Free the text with
 * erard_text_free.
 */
char *erard_diagnose_quantities(uint32_t key, size_t *length, ErardStatus *status);

/**
 * Returns the screws and parameters of an instrument that can be changed, called dials, as JSON: an array of "name",
 * "label", "note", "group", "unit", "decimals", "value", "from" and "to". Returns NULL on failure. Free the text with
 * erard_text_free.
 */
char *erard_instrument_dials(const struct ErardInstrument *instrument, size_t *length, ErardStatus *status);

/**
 * Reads what a person types into a dial's field, and writes the dial's new value, in the dial's unit, to `value`:
 * "0.3", "0.3 mm", "1/64in" (the value), "+0.5", "-0.2 mm" (a difference from this instrument's value), "x1.05" (a
 * factor of it) or "=-0.2" (a value with a sign). A number without a unit is in the dial's unit. Errors:
 * ERARD_STATUS_NO_SUCH (there is no such dial), ERARD_STATUS_ARGUMENT (the text cannot be read) and ERARD_STATUS_RANGE
 * (the value is out of the dial's range); erard_last_error says what is expected.
 */
ErardStatus erard_instrument_dial_typed(const struct ErardInstrument *instrument,
                                        const char *dial,
                                        const char *typed,
                                        double *value);

/**
 * Returns a new instrument with dials set to new values. `turns` is a JSON object of dial names and values, e.g.
 * {"let_off": -0.5, "hammer": 9.5}. All dials are set relative to this instrument, which does not change. Returns NULL
 * on failure, such as a value out of range or one that the file may not have. The new instrument belongs to the caller
 * until erard_instrument_free.
 */
struct ErardInstrument *erard_instrument_with_dials(const struct ErardInstrument *instrument,
                                                    const char *turns,
                                                    ErardStatus *status);

/**
 * Presses an instrument once, mezzo forte, and reports as JSON whether it plays: "hammer_speed_m_per_s" (null if the
 * hammer does not reach the string) and "warnings", sentences about results that cannot be trusted and parts that do
 * not work. Takes a tenth of a second. Returns NULL on failure. Free the text with erard_text_free.
 */
char *erard_instrument_test_press(const struct ErardInstrument *instrument, size_t *length, ErardStatus *status);

/**
 * Makes an event detector for one press on an action of this instrument. Returns NULL if the instrument is NULL. Real
 * time: no.
 */
struct ErardEventDetector *erard_event_detector_new(const struct ErardInstrument *instrument, ErardStatus *status);

/**
 * Frees an event detector. NULL does nothing. Real time: no.
 */
void erard_event_detector_free(struct ErardEventDetector *detector);

/**
 * Clears the events that were found, so that the next press can be observed. Real time: no.
 */
ErardStatus erard_event_detector_reset(struct ErardEventDetector *detector);

/**
 * Observes the action once. Call it before the first step of a press and after every step. Returns
 * ERARD_STATUS_FOREIGN if the action does not match the detector's instrument. Real time: no.
 */
ErardStatus erard_event_detector_observe(struct ErardEventDetector *detector, const struct ErardAction *action);

/**
 * Writes the events found so far to `events`. Real time: no.
 */
ErardStatus erard_event_detector_read(const struct ErardEventDetector *detector, struct ErardEvents *events);

/**
 * Makes an action record where its zones touch, from the next step on, for erard_action_contacts. Recording costs a
 * few percent of a step and does not change the results by a bit. Real time: no.
 */
ErardStatus erard_action_record_contacts(struct ErardAction *action);

/**
 * Writes the state of the contact zones in the last step to `numbers`, five for each zone: force, N; the contact
 * point, m in the world, x to the back and y up; the unit normal, in the direction in which the force pushes the disc.
 * They are 0 for zones that do not touch, and before erard_action_record_contacts. `count` is the room in `numbers`,
 * at least five times erard_action_zone_count, else the call returns ERARD_STATUS_SIZE. Real time: no.
 */
ErardStatus erard_action_contacts(const struct ErardAction *action, double *numbers, size_t count);

/**
 * Returns 1 if the last step changed nothing, so that further steps under the same input change nothing either; else
 * 0, also for NULL. Real time: no.
 */
uint32_t erard_action_is_asleep(const struct ErardAction *action);

/**
 * Makes a built-in touch for an instrument: `nuance` is "pp", "p", "mf", "f" or "ff" (hammer speeds at the string of
 * 0.5, 0.79, 1.99, 3.15 and 5 m/s); `struck` is 0 for a pressed touch, 1 for a struck one. A hand of 200 g plays it,
 * with a force that is adjusted to this instrument; another action is played by the same hand with the same force.
 * Returns NULL on failure: ERARD_STATUS_NO_SUCH for an unknown nuance; ERARD_STATUS_ARGUMENT if no such hand reaches
 * the hammer speed, and erard_last_error says which speed it reaches. Real time: no.
 */
struct ErardStroke *erard_stroke_builtin(const struct ErardInstrument *instrument,
                                         const char *nuance,
                                         uint32_t struck,
                                         ErardStatus *status);

/**
 * Makes a stroke for an instrument from a recording, the text of a CSV file (UTF-8, `length` bytes) with a column for
 * the time and one for force or position. Its force drives the key if there is one, else its position. The recording
 * is prepared as `erard press` does without options: the rest before the touch gives the zero, and each channel is
 * filtered by its own noise; erard_stroke_remarks lists the changes. Returns NULL on failure; erard_last_error says
 * what is wrong, with line and column. Real time: no.
 */
struct ErardStroke *erard_stroke_new(const struct ErardInstrument *instrument,
                                     const char *text,
                                     size_t length,
                                     ErardStatus *status);

/**
 * Returns the changes and remarks from preparing a recorded stroke, one in each line; empty for a built-in stroke.
 * Free the text with erard_text_free.
 */
char *erard_stroke_remarks(const struct ErardStroke *stroke, size_t *length, ErardStatus *status);

/**
 * Finds the columns of a recording by their titles and returns them as JSON: an array of "role" ("time", "force",
 * "position", "hammer"), "index" (from 0) and "title", time first. `titles` is a JSON array of all titles. Use it to
 * pass on columns of tables that are not text as CSV. Returns NULL on failure. Free the text with erard_text_free.
 */
char *erard_recording_columns(const char *titles, size_t *length, ErardStatus *status);

/**
 * Frees a stroke. NULL does nothing. Real time: no.
 */
void erard_stroke_free(struct ErardStroke *stroke);

/**
 * Returns the duration of a stroke, s, including the time in which `erard press` lets the action swing out after it; 0
 * for NULL. Real time: no.
 */
double erard_stroke_duration(const struct ErardStroke *stroke);

/**
 * Plays a stroke on an instrument from rest in steps of `step_s` (s, as for erard_action_new) and returns the text of
 * the run.csv that `erard press` writes with the same step: titles, then a row for each step. The stroke stays where
 * it is. Returns NULL on failure; erard_last_error says what is wrong. Free the text with erard_text_free. Real time:
 * no.
 */
char *erard_stroke_run_csv(const struct ErardInstrument *instrument,
                           const struct ErardStroke *stroke,
                           double step_s,
                           size_t *length,
                           ErardStatus *status);

/**
 * Sets a stroke back to its beginning. Real time: no.
 */
ErardStatus erard_stroke_rewind(struct ErardStroke *stroke);

/**
 * Takes one step of an action under the stroke's next input. From an action at rest, the positions and angles have the
 * same bits as those of `erard press`; the forces are this step's, where a row of `erard press` has the mean of the
 * steps before and after it. `reading` may be NULL. An error leaves action and stroke as they were. Real time: no.
 */
ErardStatus erard_action_step_stroke(struct ErardAction *action,
                                     struct ErardStroke *stroke,
                                     struct ErardReading *reading);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ERARD_H */
