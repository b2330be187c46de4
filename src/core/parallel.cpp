#include "scslam/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

namespace scslam {

struct ThreadPool::State {
  using Body = std::function<void(std::size_t, std::size_t, std::size_t)>;

  std::vector<std::thread> workers;
  std::mutex mutex;
  std::condition_variable work, finished;
  std::uint64_t generation = 0;
  int busy = 0;
  bool quit = false;

  const Body* body = nullptr;
  std::size_t n = 0, chunk_size = 1, chunks = 0;
  std::atomic<std::size_t> next{0};
  std::size_t failed_chunk = 0;
  std::exception_ptr failure;

  void drain() {
    for (std::size_t chunk = next++; chunk < chunks; chunk = next++) {
      try {
        (*body)(chunk * chunk_size, std::min(n, (chunk + 1) * chunk_size), chunk);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure || chunk < failed_chunk) {
          failure = std::current_exception();
          failed_chunk = chunk;
        }
      }
    }
  }

  void workerLoop() {
    std::uint64_t seen = 0;
    std::unique_lock lock(mutex);
    while (true) {
      work.wait(lock, [&] { return quit || generation != seen; });
      if (quit) return;
      seen = generation;
      lock.unlock();
      drain();
      lock.lock();
      if (--busy == 0) finished.notify_one();
    }
  }
};

ThreadPool::ThreadPool(int threads) : state_(std::make_unique<State>()) {
  if (threads < 1) throw std::invalid_argument("ThreadPool needs at least one thread");
  for (int i = 1; i < threads; ++i) state_->workers.emplace_back([s = state_.get()] { s->workerLoop(); });
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->quit = true;
  }
  state_->work.notify_all();
  for (auto& worker : state_->workers) worker.join();
}

int ThreadPool::size() const { return static_cast<int>(state_->workers.size()) + 1; }

void ThreadPool::forEachChunk(std::size_t n, std::size_t chunk_size,
                              const std::function<void(std::size_t, std::size_t, std::size_t)>& body) {
  State& s = *state_;
  const std::size_t chunks = chunkCount(n, chunk_size);
  if (s.workers.empty() || chunks <= 1) {
    for (std::size_t chunk = 0; chunk < chunks; ++chunk)
      body(chunk * chunk_size, std::min(n, (chunk + 1) * chunk_size), chunk);
    return;
  }
  {
    const std::lock_guard lock(s.mutex);
    s.body = &body;
    s.n = n, s.chunk_size = chunk_size, s.chunks = chunks;
    s.next = 0;
    s.failure = nullptr;
    s.busy = static_cast<int>(s.workers.size());
    ++s.generation;
  }
  s.work.notify_all();
  s.drain();
  std::unique_lock lock(s.mutex);
  s.finished.wait(lock, [&] { return s.busy == 0; });
  if (s.failure) std::rethrow_exception(s.failure);
}

}  // namespace scslam
