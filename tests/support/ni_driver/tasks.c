/* Analogue input tasks of the stand-in driver.

   RADARGUI_STAND_IN_CODES        file of int16 codes, 6 inputs one after the other
   RADARGUI_STAND_IN_REALTIME     samples come at their rate; otherwise all are there at once
   RADARGUI_STAND_IN_OVERFLOW_AT  the buffer is overwritten after so many samples, once */
#include "driver.h"

#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { INPUTS_SERVED = 6, MOST_CHANNELS = 16 };

typedef struct {
    const Device *device;
    char names[MOST_CHANNELS][64];
    int inputs[MOST_CHANNELS];
    int n_channels, running, broken, reserved;
    double rate_hz, started_s;
    uint32_t buffer;
    int64_t position;
} Task;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static const Device *in_use[2];
static int overflowed;
static int16_t *codes;
static int64_t n_codes;

static double now_s(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void load_codes(void) {
    const char *path = getenv("RADARGUI_STAND_IN_CODES");
    FILE *file = path && !codes ? fopen(path, "rb") : NULL;
    if (file == NULL) return;
    fseek(file, 0, SEEK_END);
    long size = ftell(file);
    rewind(file);
    codes = malloc((size_t)size);
    if (codes != NULL) n_codes = (int64_t)(fread(codes, 2, (size_t)size / 2, file) / INPUTS_SERVED);
    fclose(file);
}

static int64_t acquired(const Task *task) {
    if (getenv("RADARGUI_STAND_IN_REALTIME") == NULL) return n_codes;
    int64_t count = (int64_t)((now_s() - task->started_s) * task->rate_hz);
    return count < n_codes ? count : n_codes;
}

static double scale(int input, int power) {
    return power == 0 ? 1e-3 * input : power == 1 ? 1.5e-4 + 1e-7 * input : 0.0;
}

int32_t DAQmxCreateTask(const char *name, void **handle) {
    (void)name;
    pthread_mutex_lock(&lock);
    load_codes();
    pthread_mutex_unlock(&lock);
    Task *task = calloc(1, sizeof *task);
    task->rate_hz = 1000.0;
    *handle = task;
    return 0;
}

int32_t DAQmxGetTaskAttribute(void *handle, int32_t attribute, ...) {
    if (handle == NULL) return failed(INVALID_TASK);
    if (attribute != 0x1276) return failed(NOT_SUPPORTED);
    va_list arguments;
    va_start(arguments, attribute);
    char *value = va_arg(arguments, char *);
    int32_t status = answer_text("_unnamedTask<0>", value, va_arg(arguments, uint32_t));
    va_end(arguments);
    return status;
}

int32_t DAQmxCreateAIVoltageChan(void *handle, const char *physical, const char *name, int32_t terminal, double low,
                                 double high, int32_t units, const char *custom_scale) {
    Task *task = handle;
    (void)units, (void)custom_scale, (void)terminal;
    const Device *device = find_device(physical);
    if (device == NULL) return failed(INVALID_DEVICE);
    int input = find_input(device, physical);
    if (input < 0 || task->n_channels == MOST_CHANNELS) return failed(NO_SUCH_CHANNEL);
    if (low < -10.0 || high > 10.0) return failed(BAD_VALUE);
    task->device = device;
    task->inputs[task->n_channels] = input;
    snprintf(task->names[task->n_channels++], 64, "%s", name);
    return 0;
}

int32_t DAQmxCfgSampClkTiming(void *handle, const char *source, double rate, int32_t edge, int32_t mode,
                              uint64_t samples) {
    Task *task = handle;
    (void)source, (void)edge, (void)mode;
    task->rate_hz = rate;
    task->buffer = (uint32_t)samples;
    return 0;
}

static int32_t reserve(Task *task) {
    int32_t status = 0;
    double limit = task->device->max_multi_hz / (task->device->simultaneous ? 1 : task->n_channels);
    if (task->rate_hz > limit * (1.0 + 1e-6)) return failed(TOO_FAST);
    pthread_mutex_lock(&lock);
    int place = task->device->simultaneous;
    if (in_use[place] != NULL && !task->reserved)
        status = failed(RESERVED);
    else if (!task->reserved) {
        in_use[place] = task->device;
        task->reserved = 1;
        task->rate_hz = 20e6 / (double)(int64_t)(20e6 / task->rate_hz * (1.0 + 1e-12));
    }
    pthread_mutex_unlock(&lock);
    return status;
}

int32_t DAQmxTaskControl(void *handle, int32_t action) {
    return action == 3 || action == 4 ? reserve(handle) : 0; /* commit, reserve */
}

int32_t DAQmxGetTimingAttribute(void *handle, int32_t attribute, ...) {
    Task *task = handle;
    va_list arguments;
    va_start(arguments, attribute);
    double *value = va_arg(arguments, double *);
    va_end(arguments);
    if (attribute == 0x1344) {
        *value = task->rate_hz;
        return 0;
    }
    if (attribute != 0x1848 || task->device->simultaneous) return failed(NOT_SUPPORTED);
    double padded = 1.0 / (1.0 / task->device->fastest_convert_hz + 10e-6), spread = task->n_channels * task->rate_hz;
    *value = spread <= padded ? padded : spread < task->device->fastest_convert_hz ? spread
                                                                                   : task->device->fastest_convert_hz;
    return 0;
}

int32_t DAQmxGetBufferAttribute(void *handle, int32_t attribute, ...) {
    if (attribute != 0x186c) return failed(NOT_SUPPORTED);
    va_list arguments;
    va_start(arguments, attribute);
    *va_arg(arguments, uint32_t *) = ((Task *)handle)->buffer;
    va_end(arguments);
    return 0;
}

int32_t DAQmxGetChanAttribute(void *handle, const char *name, int32_t attribute, ...) {
    Task *task = handle;
    int channel = 0;
    while (channel < task->n_channels && strcmp(task->names[channel], name) != 0) channel++;
    if (channel == task->n_channels) return failed(NO_SUCH_CHANNEL);
    va_list arguments;
    va_start(arguments, attribute);
    void *value = va_arg(arguments, void *);
    int32_t status = 0;
    if (attribute == 0x22da)
        *(uint32_t *)value = 16;
    else if (attribute == 0x1930) {
        double coefficients[4];
        for (int power = 0; power < 4; power++) coefficients[power] = scale(task->inputs[channel], power);
        status = answer_numbers(coefficients, 4, value, va_arg(arguments, uint32_t));
    } else
        status = failed(NOT_SUPPORTED);
    va_end(arguments);
    return status;
}

int32_t DAQmxStartTask(void *handle) {
    Task *task = handle;
    int32_t status = reserve(task);
    if (status < 0) return status;
    task->position = 0;
    task->broken = 0;
    task->running = 1;
    task->started_s = now_s();
    return 0;
}

int32_t DAQmxGetReadAttribute(void *handle, int32_t attribute, ...) {
    Task *task = handle;
    if (attribute != 0x1223) return failed(NOT_SUPPORTED);
    if (!task->running) return failed(NOT_RUNNING);
    va_list arguments;
    va_start(arguments, attribute);
    *va_arg(arguments, uint32_t *) = (uint32_t)(acquired(task) - task->position);
    va_end(arguments);
    return 0;
}

/* Waits, and returns how many samples of each channel can be given; the status tells of those that cannot. */
static int64_t available(Task *task, int32_t wanted, double timeout_s, int32_t *status) {
    double deadline = now_s() + timeout_s;
    int64_t count;
    while ((count = acquired(task) - task->position) < wanted && now_s() < deadline) {
        struct timespec moment = {0, 1000000};
        nanosleep(&moment, NULL);
    }
    *status = count < wanted ? TIMEOUT : 0;
    if (count > wanted) count = wanted;
    const char *overflow = getenv("RADARGUI_STAND_IN_OVERFLOW_AT");
    if (overflow != NULL && !overflowed && task->position + count > atoll(overflow)) {
        count = atoll(overflow) - task->position;
        overflowed = task->broken = 1;
        plug_in_again();
        *status = OVERWRITTEN;
    }
    return count;
}

int32_t DAQmxReadBinaryI16(void *handle, int32_t wanted, double timeout_s, uint32_t fill, int16_t *out, uint32_t size,
                           int32_t *n_read, uint32_t *reserved) {
    Task *task = handle;
    (void)fill, (void)size, (void)reserved;
    *n_read = 0;
    if (!task->running) return failed(NOT_RUNNING);
    if (task->broken) return failed(OVERWRITTEN);
    int32_t status;
    int64_t count = available(task, wanted, timeout_s, &status);
    for (int channel = 0; channel < task->n_channels; channel++) { /* packed at the front */
        int input = task->inputs[channel];
        for (int64_t k = 0; k < count; k++)
            out[channel * count + k] = input < INPUTS_SERVED ? codes[input * n_codes + task->position + k] : 0;
    }
    task->position += count;
    *n_read = (int32_t)count;
    return status < 0 ? failed(status) : 0;
}

int32_t DAQmxStopTask(void *handle) {
    ((Task *)handle)->running = 0;
    return 0;
}

int32_t DAQmxClearTask(void *handle) {
    Task *task = handle;
    if (task == NULL) return failed(INVALID_TASK);
    pthread_mutex_lock(&lock);
    if (task->reserved) in_use[task->device->simultaneous] = NULL;
    pthread_mutex_unlock(&lock);
    free(task);
    return 0;
}
