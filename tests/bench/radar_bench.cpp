// Time of every radar extractor, of the filter and of the front-ends on sweeps of 400 x 3360 of a street-like image.
// "sweep/NAME" is what a run does with each sweep: extractor, filter, preprocess and odometry.
#include <benchmark/benchmark.h>

#include <cmath>

#include "scslam/core/counter_random.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/pipeline/slam_params.h"
#include "scslam/sensor/radar_points.h"

namespace scslam {
namespace {

/// Noise as a logarithmic receiver shows it (half of the bins zero), smooth over an echo's width, and 8 echoes a row.
RadarScan aSweep() {
  RadarScan sweep;
  sweep.resize(400, 3360);
  sweep.range_resolution_m = 0.0596;
  RandomSequence random(CounterRandom(1, RandomStream::kRadar));
  for (std::size_t a = 0; a < sweep.azimuths; ++a) {
    sweep.angles[a] = 2 * M_PI * static_cast<double>(a) / 400;
    sweep.stamps[a] = stampFromSeconds(0.000625 * static_cast<double>(a));
    double noise = 0;
    for (auto& power : sweep.row(a)) {
      noise += 0.25 * (30 * random.uniform() - 15 - noise);
      power = static_cast<std::uint8_t>(std::max(0.0, 5 * noise));
    }
    for (int echo = 0; echo < 8; ++echo) {
      const double at = 50 + 3250 * random.uniform(), top = 60 + 70 * random.uniform();
      for (int x = -12; x <= 12; ++x) {
        auto& power = sweep.row(a)[static_cast<std::size_t>(at + x)];
        power = std::max(power, static_cast<std::uint8_t>(std::max(0.0, top - 0.33 * x * x)));
      }
    }
  }
  return sweep;
}

const RadarScan& sweep() {
  static const RadarScan image = aSweep();
  return image;
}

void extract(benchmark::State& state, const std::string& name, int threads) {
  ThreadPool pool(threads);
  Log log(mrpt::system::LVL_ERROR);
  const auto extractor = Registry<RadarExtractor>::instance().create(name, PluginContext{pool, log});
  std::size_t points = 0;
  for (auto _ : state) points = extractor->extract(sweep()).size();
  state.counters["points"] = static_cast<double>(points);
}

void filter(benchmark::State& state) {
  ThreadPool pool(1);
  Log log(mrpt::system::LVL_ERROR);
  const Cloud cloud =
      Registry<RadarExtractor>::instance().create("k_strongest", PluginContext{pool, log})->extract(sweep());
  for (auto _ : state) {
    Cloud copy = cloud;
    benchmark::DoNotOptimize(filterRadarPoints(copy, sweep(), {}).removed());
  }
}

/// The same image seen on and on, turning by 0.2 degrees a sweep: its points are matched like those of a drive.
Scan nextScan(std::size_t index) {
  auto image = std::make_shared<RadarScan>(sweep());
  const Stamp start = stampFromSeconds(0.25 * static_cast<double>(index));
  for (std::size_t a = 0; a < image->azimuths; ++a) {
    image->angles[a] = std::fmod(image->angles[a] + 0.0035 * static_cast<double>(index), 2 * M_PI);
    image->stamps[a] = start + (image->stamps[a] - stampFromSeconds(0));
  }
  Scan scan;
  scan.index = index, scan.stamp = start, scan.planar = true, scan.radar = image;
  return scan;
}

void wholeSweep(benchmark::State& state, const std::string& frontend, int threads) {
  ThreadPool pool(threads);
  Log log(mrpt::system::LVL_ERROR);
  const PluginContext context{pool, log};
  SlamParams params;
  loadConfig(params, "radar");
  const RadarPoints points(params.radar, context);
  params.odometry.frontend.name = frontend;
  const auto odometry = params.odometry.frontend.create(context);
  std::size_t index = 0, found = 0;
  const auto step = [&](Scan scan) {
    std::string note;
    scan.cloud = points(*scan.radar, note);
    preprocess(scan, params.preprocess);
    found = scan.cloud.size();
    return odometry->step(scan).quality.ok;
  };
  for (; index < 5; ++index) step(nextScan(index));
  std::size_t lost = 0;
  for (auto _ : state) {
    state.PauseTiming();
    Scan scan = nextScan(index++);
    state.ResumeTiming();
    lost += !step(std::move(scan));
  }
  state.counters["points"] = static_cast<double>(found);
  state.counters["lost"] = static_cast<double>(lost);
}

}  // namespace
}  // namespace scslam

int main(int argc, char** argv) {
  for (const std::string& name : scslam::Registry<scslam::RadarExtractor>::instance().names())
    for (const int threads : {1, 2})
      benchmark::RegisterBenchmark((name + "/threads:" + std::to_string(threads)).c_str(), scslam::extract, name,
                                   threads)
          ->Unit(benchmark::kMillisecond)
          ->MeasureProcessCPUTime();
  benchmark::RegisterBenchmark("filter", scslam::filter)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
  for (const std::string& name : scslam::Registry<scslam::Odometry>::instance().names()) {
    if (!name.starts_with("radar_")) continue;
    for (const int threads : {1, 2})
      benchmark::RegisterBenchmark(("sweep/" + name + "/threads:" + std::to_string(threads)).c_str(),
                                   scslam::wholeSweep, name, threads)
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime()
          ->MeasureProcessCPUTime();
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
