/* Counts the conditions that do not hold, and prints them. */
#include <stdio.h>

static int failures;

#define EXPECT(condition)                                                  \
    do {                                                                   \
        if (!(condition)) {                                                \
            fprintf(stderr, "line %d: %s\n", __LINE__, #condition);        \
            failures++;                                                    \
        }                                                                  \
    } while (0)
