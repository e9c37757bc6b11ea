/* A keyboard driven by a list of events: three notes, two of them together. Keys at rest cost nothing.
   cc keyboard.c $(pkg-config --cflags --libs erard) -o keyboard */
#include <erard.h>
#include <stdio.h>

typedef struct {
    double time_s;
    uint32_t key;
    double force_n; /* 0 lets the key go */
} Event;

int main(void) {
    static const Event events[] = {
        {0.00, 40, 6.0}, {0.20, 40, 0.0}, {0.25, 44, 8.0}, {0.25, 47, 8.0}, {0.50, 44, 0.0}, {0.50, 47, 0.0},
    };
    const size_t count = sizeof events / sizeof *events;
    const double step_s = 50e-6;
    ErardStatus status;
    ErardKeyboard *keyboard = erard_keyboard_new(NULL, 0, step_s, &status);
    if (!keyboard) {
        fprintf(stderr, "%s\n", erard_last_error());
        return 1;
    }
    size_t next = 0;
    for (uint32_t n = 0; n < 16000; n++) {
        while (next < count && events[next].time_s <= n * step_s) {
            ErardInput input = {.struct_size = sizeof input, .force_n = events[next].force_n};
            input.kind = events[next].force_n > 0 ? ERARD_INPUT_FORCE : ERARD_INPUT_FREE;
            if (erard_keyboard_drive(keyboard, events[next].key, &input) < 0) {
                return 1;
            }
            next++;
        }
        ErardImpact impacts[8];
        impacts[0].struct_size = sizeof *impacts;
        size_t count;
        if (erard_keyboard_step(keyboard, 1, impacts, 8, &count) < 0) {
            return 1;
        }
        for (size_t b = 0; b < count && b < 8; b++) {
            printf("key %u at %.4f s with %.3f m/s\n", impacts[b].key, impacts[b].time_s, impacts[b].hammer_speed_m_per_s);
        }
    }
    printf("%u keys awake at the end\n", erard_keyboard_awake_count(keyboard));
    erard_keyboard_free(keyboard);
    return 0;
}
