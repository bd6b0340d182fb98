/*
 * The smart actuator for Octave and MATLAB.
 *
 *   state = actuator_mex(model, plant, names, values)
 *       An actuator at rest: names is a cell array of parameters, values their values.
 *   [state, readings] = actuator_mex(state, commands_deg, ticks)
 *       Holds each command for `ticks` ticks of 50 us; returns a row of readings after each. The
 *       columns: time, s; delayed command, angle, deg; rate, deg/s; duty, %; measured angle, deg;
 *       measured rate, deg/s; current, A; back-EMF, V.
 *
 * The state is a value (a column of uint64): a copy is a snapshot. It is valid within the session,
 * and its elements must not be modified.
 *
 * Build: mkoctfile --mex -I../../include actuator_mex.c libactuator_c.a
 */
#include "actuator.h"

#include <string.h>

#include "mex.h"

enum { COLUMNS = 9 };

static struct actuator actuator;

static void check(enum actuator_error error, const char *why)
{
    if (error != ACTUATOR_ERROR_NONE)
        mexErrMsgIdAndTxt("actuator:error", "%s", *why ? why : actuator_error_text(error));
}

/* The text of an argument; Octave frees it when the function ends. */
static char *text(const mxArray *array)
{
    char *result = array ? mxArrayToString(array) : NULL;
    if (!result)
        mexErrMsgIdAndTxt("actuator:usage", "expected a text");
    return result;
}

static void start(int count, const mxArray *arguments[])
{
    struct actuator_settings settings;
    struct actuator_why why;
    char *model = text(arguments[0]), *plant = text(arguments[1]);
    size_t parameters = 0, i;

    /* An empty text: the model has no plant. */
    check(actuator_settings_init(&settings, sizeof settings, model, *plant ? plant : NULL, &why), why.text);
    if (count == 4) {
        parameters = mxGetNumberOfElements(arguments[2]);
        if (!mxIsCell(arguments[2]) || !mxIsDouble(arguments[3]) ||
            mxGetNumberOfElements(arguments[3]) != parameters)
            mexErrMsgIdAndTxt("actuator:usage", "expected a cell of names and as many values");
    }
    for (i = 0; i < parameters; i++) {
        char *name = text(mxGetCell(arguments[2], i));
        check(actuator_settings_set(&settings, name, mxGetPr(arguments[3])[i], &why), why.text);
    }
    check(actuator_start(&actuator, sizeof actuator, &settings, &why), why.text);
}

static mxArray *advance(const mxArray *arguments[])
{
    const double *commands_deg = mxGetPr(arguments[1]);
    size_t rows = mxGetNumberOfElements(arguments[1]), row;
    double ticks = mxGetScalar(arguments[2]);
    mxArray *readings;
    double *out;

    /* Written so that NaN fails; a double represents every permitted number of ticks exactly. */
    if (!(ticks >= 0.0 && ticks <= (double)ACTUATOR_LONGEST_STEP_TICKS && ticks == (double)(uint64_t)ticks))
        mexErrMsgIdAndTxt("actuator:usage", "expected a whole number of ticks");
    readings = mxCreateDoubleMatrix(rows, COLUMNS, mxREAL);
    out = mxGetPr(readings);
    for (row = 0; row < rows; row++) {
        struct actuator_reading now;
        check(actuator_advance(&actuator, commands_deg[row], (uint64_t)ticks), "");
        check(actuator_read(&actuator, &now), "");
        out[row + 0 * rows] = (double)now.tick / ACTUATOR_TICKS_PER_SECOND;
        out[row + 1 * rows] = now.command_deg;
        out[row + 2 * rows] = now.angle_deg;
        out[row + 3 * rows] = now.rate_deg_s;
        out[row + 4 * rows] = now.duty_pct;
        out[row + 5 * rows] = now.angle_meas_deg;
        out[row + 6 * rows] = now.rate_meas_deg_s;
        out[row + 7 * rows] = now.current_a;
        out[row + 8 * rows] = now.back_emf_v;
    }
    return readings;
}

static int is_state(const mxArray *array)
{
    return mxIsUint64(array) && mxGetNumberOfElements(array) == ACTUATOR_WORDS;
}

void mexFunction(int results, mxArray *result[], int count, const mxArray *arguments[])
{
    mxArray *readings = NULL;

    if (actuator_abi_version() != ACTUATOR_ABI_VERSION)
        mexErrMsgIdAndTxt("actuator:version", "header and library are of different versions");
    if (count == 3 && is_state(arguments[0]) && mxIsDouble(arguments[1]) && mxIsDouble(arguments[2]) &&
        mxGetNumberOfElements(arguments[2]) == 1) {
        memcpy(&actuator, mxGetData(arguments[0]), sizeof actuator);
        readings = advance(arguments);
    } else if ((count == 2 || count == 4) && results <= 1) {
        start(count, arguments);
    } else {
        mexErrMsgIdAndTxt("actuator:usage", "expected (model, plant[, names, values]) or (state, commands_deg, ticks)");
    }
    result[0] = mxCreateNumericMatrix(ACTUATOR_WORDS, 1, mxUINT64_CLASS, mxREAL);
    memcpy(mxGetData(result[0]), &actuator, sizeof actuator);
    if (results > 1)
        result[1] = readings;
}
