#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <vector>

namespace lode::diamond {

/// Which thread does what next, where each slab of a volume has its signs found, its vertices and
/// triangles counted and then written, while what it reads is still in the caches. Counting a slab
/// needs the signs of the next one too, writing it where the vertices of the next one begin. Slabs
/// are placed one after the other, as soon as all before them are counted.
class SlabSchedule {
 public:
  enum class Step : std::uint8_t { find, count, write };
  struct Task {
    Step step;
    std::size_t slab;
  };

  /// place(slab): takes note of where the slab's vertices and triangles begin, and whether there is
  /// room for them yet. Never called by two threads at once.
  SlabSchedule(std::size_t n_slabs, std::function<bool(std::size_t)> place);

  /// Calls body(task) until nothing is left, or nothing that there is room for. Several threads may
  /// do so at once, and one alone comes to the end too. What a body throws ends it for all.
  void work(const std::function<void(const Task&)>& body);

  /// There is room for all slabs now. All must have been placed, and no thread be at work.
  void make_room() { n_with_room_ = n_slabs_; }
  [[nodiscard]] bool is_complete() const { return n_written_ == n_slabs_; }

 private:
  /// The next task, waiting for those it needs; nothing if none will come.
  std::optional<Task> take();
  [[nodiscard]] std::optional<Task> next_ready();
  [[nodiscard]] bool is_idle_for_good() const;
  void finish(const Task& task);
  void stop();

  std::size_t n_slabs_;
  std::function<bool(std::size_t)> place_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::uint8_t> is_found_, is_counted_;  ///< By slab.
  std::size_t next_find_ = 0, next_count_ = 0, next_write_ = 0;
  std::size_t n_found_ = 0;      ///< Slabs before this one all are,
  std::size_t n_placed_ = 0;     ///< and these.
  std::size_t n_with_room_ = 0;  ///< The first ones.
  std::size_t n_written_ = 0;
  int n_waiting_ = 0;
  bool is_full_ = false;  ///< A placed slab had no room.
  bool is_stopped_ = false;
};

}  // namespace lode::diamond
