/* A plugin in C: sizes are x times the number in the options (which is 1 without options). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "lumesh/sizing.h"

int lumesh_sizing_abi_version(void) { return LUMESH_SIZING_ABI_VERSION; }

int lumesh_sizing_create(const char* options, void** state, char* message, size_t message_size) {
  double* factor = malloc(sizeof *factor);
  if (factor == NULL) return 1;
  *factor = options[0] == '\0' ? 1 : atof(options);
  if (*factor > 0) {
    *state = factor;
    return 0;
  }
  free(factor);
  if (options[0] != '-') snprintf(message, message_size, "'%s' is no factor; give a number\nand more lines", options);
  return 7;
}

void lumesh_sizing_destroy(void* state) { free(state); }

double lumesh_size_at(void* state, double x, double y, double z) {
  (void)y;
  (void)z;
  return *(const double*)state * x;
}

/* Where the last point's z is larger than the first one's x. */
int lumesh_should_be_adapted(void* state, const double* points, int n) {
  (void)state;
  return points[3 * n - 1] > points[0] ? -5 : 0;
}
