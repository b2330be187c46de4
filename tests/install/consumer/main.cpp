#include <scslam/core/log.h>
#include <scslam/core/parallel.h>
#include <scslam/odometry/odometry.h>

#include <cstdio>

int main() {
  scslam::Log log;
  scslam::ThreadPool threads(1);
  for (const auto& name : scslam::Registry<scslam::Odometry>::instance().names()) std::puts(name.c_str());
  return scslam::Registry<scslam::Odometry>::instance().create("voxel_icp", {threads, log}) ? 0 : 1;
}
