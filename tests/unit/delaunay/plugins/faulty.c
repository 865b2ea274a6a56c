/* Plugins that lack something; the build says what there is. */
#include "lumesh/sizing.h"

int a_function_that_is_nowhere(void);

#ifdef VERSION
int lumesh_sizing_abi_version(void) {
#ifdef UNDEFINED
  return a_function_that_is_nowhere();
#else
  return VERSION;
#endif
}
#endif

#ifdef FUNCTIONS
double lumesh_size_at(void* state, double x, double y, double z) {
  (void)state;
  return x + y + z;
}
#endif
