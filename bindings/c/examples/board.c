/* Readings of keys in, bytes of MIDI out. The lines are those of `erard live`: time_us,key,raw, all keys in every scan.
   cc board.c $(pkg-config --cflags --libs erard) -o board && ./board < readings.csv > notes.bin */
#include <erard.h>
#include <stdio.h>
#include <stdlib.h>

enum { FIRST = 40, KEYS = 3 };
static uint8_t midi[KEYS * ERARD_BOARD_KEY_BYTES];
static size_t length;

static void send(ErardStatus status) {
    if (status < 0) {
        fprintf(stderr, "%s\n", erard_status_text(status));
        exit(1);
    }
    fwrite(midi, 1, length, stdout);
}

int main(void) {
    ErardBoardSetup setup = {.struct_size = sizeof setup, .first_key = FIRST, .key_count = KEYS, .travel_m = 0.01};
    ErardStops stops[KEYS] = {{.struct_size = sizeof *stops}};
    for (int k = 0; k < KEYS; k++) stops[k].rest = 3500, stops[k].pressed = 700;
    void *memory = malloc(erard_board_bytes(KEYS));
    ErardStatus status;
    ErardBoard *board = erard_board_new(memory, erard_board_bytes(KEYS), &setup, stops, NULL, 0, &status);
    if (!board) return fprintf(stderr, "%s\n", erard_last_error()), 1;
    float readings[KEYS] = {0};
    double time_us;
    unsigned key;
    float raw;
    if (scanf("%*[^\n]") == EOF) return 1; /* the header */
    while (scanf("%lf,%u,%f", &time_us, &key, &raw) == 3 && key >= FIRST && key < FIRST + KEYS) {
        readings[key - FIRST] = raw;
        if (key == FIRST + KEYS - 1) send(erard_board_scan(board, 1e-6 * time_us, readings, KEYS, midi, sizeof midi, &length));
    }
    send(erard_board_let_go(board, midi, sizeof midi, &length));
    erard_board_free(board);
    free(memory);
    return 0;
}
