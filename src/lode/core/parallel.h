#pragma once

#include <cstddef>
#include <functional>

namespace lode {

/// How many threads an operation may use; 0 means all the machine has.
struct Threads {
  int count = 0;
};

/// The number of workers parallel_for will use: `threads.count`, or the number of cores.
[[nodiscard]] int n_workers(Threads threads);

/// Calls body(i, worker) for each i in [0, n), in chunks of about `grain`, on at most
/// n_workers(threads) threads. `worker` is in [0, n_workers) and no two calls with the same
/// worker run at once, so it may index scratch space. Order is unspecified: results must not
/// depend on it.
void parallel_for(std::size_t n, Threads threads, std::size_t grain,
                  const std::function<void(std::size_t i, int worker)>& body);

}  // namespace lode
