#include "lode/models/diamond/slab_schedule.h"

#include <algorithm>
#include <utility>

namespace lode::diamond {

SlabSchedule::SlabSchedule(std::size_t n_slabs, std::function<bool(std::size_t)> place)
    : n_slabs_(n_slabs), place_(std::move(place)), is_found_(n_slabs), is_counted_(n_slabs) {}

void SlabSchedule::work(const std::function<void(const Task&)>& body) {
  try {
    while (const auto task = take()) {
      body(*task);
      finish(*task);
    }
  } catch (...) {
    stop();
    throw;
  }
}

std::optional<SlabSchedule::Task> SlabSchedule::take() {
  std::unique_lock lock(mutex_);
  while (!is_stopped_) {
    if (const auto task = next_ready()) return task;
    if (is_idle_for_good()) return {};
    ++n_waiting_;
    changed_.wait(lock);
    --n_waiting_;
  }
  return {};
}

/// Slabs that can be written come first: what they read is in the caches.
std::optional<SlabSchedule::Task> SlabSchedule::next_ready() {
  const auto with_next = [this](std::size_t slab) { return std::min(slab + 2, n_slabs_); };
  if (next_write_ < n_with_room_ && n_placed_ >= with_next(next_write_))
    return Task{Step::write, next_write_++};
  if (next_count_ < n_slabs_ && n_found_ >= with_next(next_count_))
    return Task{Step::count, next_count_++};
  if (next_find_ < n_slabs_) return Task{Step::find, next_find_++};
  return {};
}

/// Whether no task that others are at will make another one ready.
bool SlabSchedule::is_idle_for_good() const {
  if (next_count_ < n_slabs_) return false;
  return n_placed_ == n_slabs_ && next_write_ == n_with_room_;
}

void SlabSchedule::finish(const Task& task) {
  const std::lock_guard lock(mutex_);
  switch (task.step) {
    case Step::find:
      is_found_[task.slab] = 1;
      while (n_found_ < n_slabs_ && is_found_[n_found_] != 0) ++n_found_;
      break;
    case Step::count:
      is_counted_[task.slab] = 1;
      for (; n_placed_ < n_slabs_ && is_counted_[n_placed_] != 0; ++n_placed_) {
        is_full_ = !place_(n_placed_) || is_full_;
        if (!is_full_) n_with_room_ = n_placed_ + 1;
      }
      break;
    case Step::write: ++n_written_; break;
  }
  if (n_waiting_ > 0) changed_.notify_all();
}

void SlabSchedule::stop() {
  const std::lock_guard lock(mutex_);
  is_stopped_ = true;
  changed_.notify_all();
}

}  // namespace lode::diamond
