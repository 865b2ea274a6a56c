/* A plugin with the paper's function alone, and without state. */
#include "lumesh/sizing.h"

int lumesh_sizing_abi_version(void) { return LUMESH_SIZING_ABI_VERSION; }

int lumesh_should_be_adapted(void* state, const double* points, int n) {
  return state == NULL && n == 4 && points[11] > 11;
}
