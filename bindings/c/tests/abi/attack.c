/* The harness of attack.rs: its cases are written from the header. */
#include <erard.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static ErardAction *action;
static ErardInstrument *instrument;
static ErardKeyboard *keyboard;
static ErardStroke *stroke;
static ErardEventDetector *detector;
static ErardReading readings[8];
static ErardImpact impacts[4096];
static ErardEvents events;
static ErardBoard *board, *contact_board, *hammer_board;
static ErardContacts contacts = {
    .struct_size = sizeof contacts, .count = 2, .off = 1, .point_count = {2}, .depths_m = {3e-3, 6.5e-3}, .bounce_s = 2e-3,
    .points = {{{5e-3, 5.0, 0.0, 0.0}, {80e-3, 0.3, 0.0, 0.0}}}
};
static ErardRelease release = {.struct_size = sizeof release, .travel_m = 0.01, .off_m = 4e-3};
static ErardBoardSetup setup = {.struct_size = sizeof setup, .first_key = 40, .key_count = 2, .travel_m = 0.01};
/* As many as a board has keys at most, whatever count is given. */
static ErardStops key_stops[88];
static ErardBoardKey board_key;
static double board_memory[1 << 16], contact_memory[1 << 12], hammer_memory[1 << 12], more_memory[1 << 16];
static ErardInput input;
static ErardStatus status;
static double doubles[4096], pairs[4096][2];
static float floats[4096];
static uint8_t bytes[1 << 22];
static uint8_t saved[1 << 20], now[1 << 20];
static size_t saved_size, now_size, count;
static char long_text[100001];
static const char *shown;
static int seed, faults, was_refused, done, refused;

static void wrong(const char *why) {
    faults++;
    printf("wrong: seed %d: %s: %s\n", seed, shown, why);
    fflush(stdout);
}

static size_t strlen_of(const char *text) { return text ? strlen(text) : 0; }

static int32_t stops(double share, void *user) { (void)user; (void)share; return 0; }
static int left;
static int32_t stops_late(double share, void *user) { (void)user; (void)share; return left-- > 0; }

static void in_table(int code) {
    if (code < -13 || code > 1) wrong("a code that is not in the table");
    if (code == ERARD_STATUS_INTERNAL) wrong(erard_last_error());
    was_refused = code < 0;
    if (code < 0) {
        refused++;
        size_t said = strlen_of(erard_last_error());
        if (said < 4) wrong("refused without a word");
        /* What must answer in real time leaves the words of the call before. */
        if (said > 4000) wrong("a message that nobody reads");
    } else {
        done++;
    }
}

/* A call that answers with a code; `bad`: an argument is no number. */
static void answered(int code, int bad) {
    in_table(code);
    if (bad && code >= 0) wrong("a number that is none was taken");
}

/* A call that makes something, or says why not. */
static void made(int is_there, int code, int told, int bad) {
    if (!told) { was_refused = !is_there; return; }
    in_table(code);
    if (is_there != (code >= 0)) wrong("the code and what was made contradict each other");
    if (bad && is_there) wrong("a number that is none was taken");
}

static void begin(void) {
    ErardStatus found = ERARD_STATUS_OK;
    /* The words of the call before, for those that leave them. */
    if (erard_instrument_builtin("harpsichord", &found) || strlen_of(erard_last_error()) < 4) {
        wrong("an unknown instrument, without a word");
    }
    instrument = erard_instrument_builtin("concert-grand-rigid", &found);
    action = erard_action_of_instrument(instrument, 50e-6, &found);
    keyboard = erard_keyboard_builtin("concert-grand", 50e-6, &found);
    stroke = erard_stroke_builtin(instrument, "mf", 0, &found);
    detector = erard_event_detector_new(instrument, &found);
    for (size_t k = 0; k < sizeof key_stops / sizeof *key_stops; k++) {
        key_stops[k] = (ErardStops){.struct_size = sizeof *key_stops, .rest = 3500, .pressed = 700};
    }
    board = erard_board_new(board_memory, sizeof board_memory, &setup, key_stops, NULL, 0, &found);
    ErardBoardSetup plain = {.struct_size = sizeof plain, .first_key = 40, .key_count = 2};
    contact_board = erard_board_contacts_new(contact_memory, sizeof contact_memory, &plain, &contacts, &found);
    plain.travel_m = 0.046;
    hammer_board = erard_board_hammers_new(
        hammer_memory, sizeof hammer_memory, &plain, key_stops, &release, key_stops, &found);
    if (!instrument || !action || !keyboard || !stroke || !detector || !board || !contact_board || !hammer_board) {
        printf("wrong: the objects: %s\n", erard_last_error());
        exit(0);
    }
}

/* Mostly right, at times none of the struct's. */
static uint32_t size_by_chance(size_t right, int which) {
    const uint32_t wrong_sizes[] = {0, 8, UINT32_MAX};
    return which % 4 ? (uint32_t)right : wrong_sizes[which / 4 % 3];
}

static void play(int which) {
    seed = which;
    readings[0].struct_size = size_by_chance(sizeof *readings, which / 2);
    impacts[0].struct_size = size_by_chance(sizeof *impacts, which / 2);
    events.struct_size = size_by_chance(sizeof events, which / 2);
    board_key.struct_size = size_by_chance(sizeof board_key, which / 2);
    key_stops[0].struct_size = size_by_chance(sizeof *key_stops, which / 2);
    setup.struct_size = size_by_chance(sizeof setup, which / 3);
    contacts.struct_size = size_by_chance(sizeof contacts, which / 2);
    release.struct_size = size_by_chance(sizeof release, which / 2);
    status = ERARD_STATUS_OK;
    count = 16;
    left = 3;
    was_refused = 0;
    switch (which) {
/* CASES */
    default: break;
    }
}

int main(int arguments, char **names) {
    if (arguments != 3) return 1;
    /* Few seeds may draw none of the functions that take these. */
    (void)impacts; (void)events; (void)status; (void)floats; (void)bytes; (void)count;
    (void)stops; (void)stops_late; (void)more_memory; (void)pairs;
    memset(long_text, 'a', sizeof long_text - 1);
    begin();
    for (int n = 0; n < 200; n++) erard_action_step_force(action, 5.0, NULL);
    for (int which = atoi(names[1]); which < atoi(names[2]); which++) {
        saved_size = sizeof saved;
        if (erard_action_save(action, saved, &saved_size) < 0) wrong("it cannot be saved");
        printf("at %d\n", which);
        fflush(stdout);
        play(which);
        ErardReading reading = {.struct_size = sizeof reading};
        if (erard_action_read(action, &reading) < 0) wrong("it cannot be read");
        if (!isfinite(reading.key_m + reading.hammer_rise_m + reading.finger_force_n + reading.string_n)) wrong("not finite");
        now_size = sizeof now;
        if (erard_action_save(action, now, &now_size) < 0) wrong("it cannot be saved any more");
        if (was_refused && (now_size != saved_size || memcmp(saved, now, saved_size))) wrong("refused, and the action is another");
        /* It plays on from where it was. */
        if (erard_action_restore(action, saved, saved_size) < 0) wrong("it does not come back");
        if (erard_action_step_force(action, 5.0, &reading) < 0 || !isfinite(reading.key_m)) wrong("it does not play on");
        if (erard_action_restore(action, saved, saved_size) < 0) wrong("it does not come back twice");
    }
    printf("ends: %d done, %d refused, %d wrong\n", done, refused, faults);
    erard_board_free(hammer_board);
    erard_board_free(contact_board);
    erard_board_free(board);
    erard_event_detector_free(detector);
    erard_stroke_free(stroke);
    erard_keyboard_free(keyboard);
    erard_action_free(action);
    erard_instrument_free(instrument);
    return 0;
}
