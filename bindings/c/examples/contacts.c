/* Edges of keys with two contacts in, bytes of MIDI out. The lines are those of `erard live`: time_us,key,contact,state.
   cc contacts.c $(pkg-config --cflags --libs erard) -o contacts && ./contacts < edges.csv > notes.bin */
#include <erard.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { KEYS = 88 };
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
    ErardBoardSetup setup = {.struct_size = sizeof setup, .first_key = 1, .key_count = KEYS};
    ErardContacts contacts = {.struct_size = sizeof contacts, .count = 2, .depths_m = {3e-3, 6.5e-3}, .bounce_s = 2e-3};
    contacts.scan_period_s = 250e-6;
    /* On a computer. A program for a chip has the result as a constant. */
    if (erard_contacts_simulate(&contacts, NULL, 0) < 0) return fprintf(stderr, "%s\n", erard_last_error()), 1;
    void *memory = malloc(erard_board_contacts_bytes(KEYS));
    ErardBoard *board = erard_board_contacts_new(memory, erard_board_contacts_bytes(KEYS), &setup, &contacts, NULL);
    if (!board) return fprintf(stderr, "%s\n", erard_last_error()), 1;
    double time_us;
    unsigned key, contact;
    char state[8];
    if (scanf("%*[^\n]") == EOF) return 1; /* the header */
    while (scanf("%lf,%u,%u,%7s", &time_us, &key, &contact, state) == 4) {
        unsigned is_made = strcmp(state, "made") == 0;
        send(erard_board_edge(board, 1e-6 * time_us, key, contact, is_made, midi, sizeof midi, &length));
    }
    send(erard_board_let_go(board, midi, sizeof midi, &length));
    erard_board_free(board);
    free(memory);
    return 0;
}
