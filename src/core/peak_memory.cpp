#include "scslam/core/peak_memory.h"

#include <sys/resource.h>

namespace scslam {

double peakRssMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

}  // namespace scslam
