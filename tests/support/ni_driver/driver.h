/* The stand-in NI-DAQmx driver library: two devices, one task each, samples from a file. */
#ifndef STAND_IN_DRIVER_H
#define STAND_IN_DRIVER_H

#include <stdint.h>

typedef struct {
    const char *name, *product;
    uint32_t serial;
    int n_inputs;
    int terminals; /* bits: 1 RSE, 2 NRSE, 4 differential */
    int simultaneous;
    double max_single_hz, max_multi_hz, fastest_convert_hz;
    const char *lines; /* terminals, separated by ", " */
} Device;

/* Returns the device of "Dev1" or of "Dev1/ai0", NULL where there is none. */
const Device *find_device(const char *name);
/* Returns the number of an input of a device, "Dev1/ai3" -> 3, -1 where there is none. */
int find_input(const Device *device, const char *physical);
/* Sets what DAQmxGetExtendedErrorInfo tells, and returns the code. */
int32_t failed(int32_t code);
/* Answers a question for a string: its size where none is given room, else 0 with the text. */
int32_t answer_text(const char *text, char *value, uint32_t size);
/* The same for numbers. */
int32_t answer_numbers(const double *numbers, uint32_t count, double *value, uint32_t size);

/* Lets the devices have been plugged in again, where the environment names a file for it. */
void plug_in_again(void);

enum {
    TIMEOUT = -200284, OVERWRITTEN = -200279, INVALID_DEVICE = -200220, NO_SUCH_CHANNEL = -200170,
    NOT_SUPPORTED = -200197, RESERVED = -50103, INVALID_TASK = -200088, BAD_VALUE = -200077, TOO_FAST = -200081,
    NOT_RUNNING = -200983
};

#endif
