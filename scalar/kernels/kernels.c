/* The inner loops of a calibration on planes (frames of a chain, compression of scans, a first guess, and a Levenberg-Marquardt fit),
and gains of candidates.

Each function has a counterpart in NumPy, which is used where no C compiler was at hand when the package was built. `scalar/kernels/__init__.py` loads
the functions; tests/test_kernels.py, tests/test_kernels_of_contacts.py and tests/diagnosis/selection/test_compiled_gains.py compare
the two. All numbers are double precision, all arrays are row-major and contiguous.
The sums are written in a fixed order, and no flag lets the compiler change it: the same data give the same bytes on all processors of one
architecture. */

#include "contacts.h"
#include "extension_gains.h"
#include "levenberg_marquardt.h"
#include "likelihood.h"
#include "linear_start.h"
#include "published_model.h"
#include "scans.h"
#include "set_gains.h"

#ifndef SOURCE_CHECKSUM
#define SOURCE_CHECKSUM 0
#endif

uint32_t source_checksum(void) { return SOURCE_CHECKSUM; }
