/* The devices of the stand-in driver and what is asked about them; the numbers are NI-DAQmx's attributes.

   RADARGUI_STAND_IN_REPLUGGED  a file that appears when the devices were plugged in again, with an overflow if not
                                before: a process that asked before that is not told their rates and ranges any more,
                                nor whether they sample simultaneously */
#include "driver.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const Device DEVICES[] = {
    {"Dev1", "DAQPad-6015", 0x0123ABCD, 16, 7, 0, 200e3, 200e3, 200e3, "/Dev1/PFI0, /Dev1/PFI1, /Dev1/ai/SampleClock"},
    {"Dev2", "USB-6356", 0x01D5A2F0, 8, 4, 1, 1.25e6, 1.25e6, 0, "/Dev2/PFI0, /Dev2/APFI0"},
};
static const double RANGES[] = {-0.5, 0.5, -5.0, 5.0, -10.0, 10.0};
static _Thread_local int32_t last_error;

int32_t failed(int32_t code) {
    last_error = code;
    return code;
}

static const char *text_of(int32_t code) {
    switch (code) {
    case TIMEOUT: return "Some or all of the samples requested have not yet been acquired.";
    case OVERWRITTEN: return "The application is not able to keep up with the hardware acquisition.";
    case INVALID_DEVICE: return "Device identifier is invalid.";
    case NO_SUCH_CHANNEL: return "Physical channel specified does not exist on this device.";
    case NOT_SUPPORTED: return "Attribute not supported.";
    case RESERVED: return "The specified resource is reserved.";
    case INVALID_TASK: return "Task specified is invalid or does not exist.";
    case BAD_VALUE: return "Requested value is not a supported value for this property.";
    case TOO_FAST: return "Sample rate exceeds the maximum sample rate for the number of channels specified.";
    default: return "An error.";
    }
}

int32_t DAQmxGetExtendedErrorInfo(char *text, uint32_t size) {
    snprintf(text, size, "%s\n\nTask Name: _unnamedTask<0>\n\nStatus Code: %d", text_of(last_error), last_error);
    return 0;
}

int32_t DAQmxGetErrorString(int32_t code, char *text, uint32_t size) {
    snprintf(text, size, "%s", text_of(code));
    return 0;
}

const Device *find_device(const char *name) {
    size_t length = strcspn(name, "/");
    for (size_t k = 0; k < sizeof DEVICES / sizeof *DEVICES; k++)
        if (strlen(DEVICES[k].name) == length && strncmp(DEVICES[k].name, name, length) == 0) return &DEVICES[k];
    return NULL;
}

int find_input(const Device *device, const char *physical) {
    const char *input = strchr(physical, '/');
    int number;
    if (input == NULL || sscanf(input, "/ai%d", &number) != 1 || number < 0 || number >= device->n_inputs) return -1;
    return number;
}

int32_t answer_text(const char *text, char *value, uint32_t size) {
    uint32_t needed = (uint32_t)strlen(text) + 1;
    if (size == 0) return (int32_t)needed;
    snprintf(value, size, "%s", text);
    return 0;
}

int32_t answer_numbers(const double *numbers, uint32_t count, double *value, uint32_t size) {
    if (size == 0) return (int32_t)count;
    memcpy(value, numbers, (size < count ? size : count) * sizeof *numbers);
    return 0;
}

int32_t DAQmxGetSystemInfoAttribute(int32_t attribute, ...) {
    va_list arguments;
    va_start(arguments, attribute);
    void *value = va_arg(arguments, void *);
    int32_t status = 0;
    switch (attribute) {
    case 0x1272: *(uint32_t *)value = 23; break;
    case 0x1923: *(uint32_t *)value = 5; break;
    case 0x2f22: *(uint32_t *)value = 0; break;
    case 0x193b: status = answer_text("Dev1, Dev2", value, va_arg(arguments, uint32_t)); break;
    default: status = failed(NOT_SUPPORTED);
    }
    va_end(arguments);
    return status;
}

static int32_t answer_inputs(const Device *device, char *value, uint32_t size) {
    char text[512] = "";
    for (int k = 0; k < device->n_inputs; k++) {
        size_t used = strlen(text);
        snprintf(text + used, sizeof text - used, "%s%s/ai%d", k ? ", " : "", device->name, k);
    }
    return answer_text(text, value, size);
}

void plug_in_again(void) {
    const char *path = getenv("RADARGUI_STAND_IN_REPLUGGED");
    FILE *file = path != NULL ? fopen(path, "w") : NULL;
    if (file != NULL) fclose(file);
}

static int replugged(void) {
    static int at_first = -1;
    const char *path = getenv("RADARGUI_STAND_IN_REPLUGGED");
    int now = path != NULL && access(path, F_OK) == 0;
    if (at_first < 0) at_first = now;
    return now && !at_first;
}

int32_t DAQmxGetDeviceAttribute(const char *name, int32_t attribute, ...) {
    const Device *device = find_device(name);
    if (device == NULL) return failed(INVALID_DEVICE);
    if (replugged() && attribute >= 0x298c && attribute <= 0x2990) return failed(NOT_SUPPORTED);
    va_list arguments;
    va_start(arguments, attribute);
    void *value = va_arg(arguments, void *);
    int32_t status = 0;
    switch (attribute) {
    case 0x631: status = answer_text(device->product, value, va_arg(arguments, uint32_t)); break;
    case 0x231e: status = answer_inputs(device, value, va_arg(arguments, uint32_t)); break;
    case 0x2a40: status = answer_text(device->lines, value, va_arg(arguments, uint32_t)); break;
    case 0x2990: status = answer_numbers(RANGES, 6, value, va_arg(arguments, uint32_t)); break;
    case 0x632: *(uint32_t *)value = device->serial; break;
    case 0x22ca: *(uint32_t *)value = 0; break;
    case 0x2985: *(uint32_t *)value = 1; break;
    case 0x2984: *(uint32_t *)value = (uint32_t)device->simultaneous; break;
    case 0x298f: *(uint32_t *)value = (uint32_t)device->simultaneous; break;
    case 0x2986: *(int32_t *)value = 4 | 8; break;
    case 0x298c: *(double *)value = device->max_single_hz; break;
    case 0x298d: *(double *)value = device->max_multi_hz; break;
    case 0x298e: *(double *)value = 0.0119; break;
    default: status = failed(NOT_SUPPORTED);
    }
    va_end(arguments);
    return status;
}

int32_t DAQmxGetPhysicalChanAttribute(const char *physical, int32_t attribute, ...) {
    const Device *device = find_device(physical);
    if (device == NULL || find_input(device, physical) < 0) return failed(NO_SUCH_CHANNEL);
    if (attribute != 0x2342) return failed(NOT_SUPPORTED);
    va_list arguments;
    va_start(arguments, attribute);
    int upper = !device->simultaneous && find_input(device, physical) >= device->n_inputs / 2;
    *va_arg(arguments, int32_t *) = upper ? device->terminals & 3 : device->terminals;
    va_end(arguments);
    return 0;
}
