// Deterministic parallelism: work is cut into fixed chunks that depend on the input alone, never on the number of
// threads.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>

namespace scslam {

class ThreadPool {
 public:
  /// @param threads that work at the same time, the caller included; >= 1.
  explicit ThreadPool(int threads = 1);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int size() const;

  /// Calls body(begin, end, chunk) for [0, n) cut into chunks of `chunk_size` (the last may be shorter), in any order
  /// on any thread, and returns when all are done. A reduction writes one partial per chunk and adds them up in chunk
  /// order. The first exception (by chunk number) is rethrown. Not reentrant: a body does not call forEachChunk.
  void forEachChunk(std::size_t n, std::size_t chunk_size,
                    const std::function<void(std::size_t begin, std::size_t end, std::size_t chunk)>& body);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Number of chunks forEachChunk makes.
inline std::size_t chunkCount(std::size_t n, std::size_t chunk_size) { return (n + chunk_size - 1) / chunk_size; }

}  // namespace scslam
