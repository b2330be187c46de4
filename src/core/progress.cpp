#include "scslam/core/progress.h"

#include <fmt/format.h>
#include <unistd.h>
#include <cmath>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace scslam {
namespace {

double nowSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string clock(double seconds) {
  const auto s = std::lround(seconds);
  return s >= 3600 ? fmt::format("{}:{:02d}:{:02d}", s / 3600, s / 60 % 60, s % 60)
                   : fmt::format("{}:{:02d}", s / 60, s % 60);
}

}  // namespace

Progress::Progress(std::string what, std::optional<std::size_t> total, bool quiet)
    : what_(std::move(what)),
      total_(total),
      quiet_(quiet),
      terminal_(::isatty(STDERR_FILENO) == 1),
      start_s_(nowSeconds()) {
  next_line_ = total_ ? (*total_ + 9) / 10 : 1000;
}

Progress::~Progress() { finish(); }

void Progress::update(std::size_t done) {
  done_ = done;
  if (quiet_) return;
  if (terminal_) {
    if (nowSeconds() - last_print_s_ > 0.1) print(done, false);
  } else if (done >= next_line_ && next_line_ > 0) {
    print(done, false);
    const std::size_t stride = total_ ? (*total_ + 9) / 10 : 1000;
    next_line_ = (done / stride + 1) * stride;
  }
}

void Progress::finish() {
  if (finished_) return;
  finished_ = true;
  if (!quiet_ && terminal_) print(done_, true);
}

void Progress::print(std::size_t done, bool last) {
  last_print_s_ = nowSeconds();
  const double elapsed = last_print_s_ - start_s_;
  std::string line;
  if (total_ && *total_ > 0) {
    const double share = std::min(1.0, static_cast<double>(done) / static_cast<double>(*total_));
    line = fmt::format("{}: {}/{} ({:.0f} %), {} elapsed", what_, done, *total_, 100 * share, clock(elapsed));
    if (share > 0 && share < 1) line += fmt::format(", {} left", clock(elapsed / share - elapsed));
    if (terminal_) {
      const auto filled = static_cast<std::size_t>(share * 24);
      line = fmt::format("[{:#<{}}{:.<{}}] {}", "", filled, "", 24 - filled, line);
    }
  } else {
    line = fmt::format("{}: {}, {} elapsed", what_, done, clock(elapsed));
  }
  if (terminal_)
    fmt::print(stderr, "\r{}\x1b[K{}", line, last ? "\n" : "");
  else
    fmt::print(stderr, "{}\n", line);
  std::fflush(stderr);
}

}  // namespace scslam
