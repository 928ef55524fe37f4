#pragma once

#include "bench/papers/cases.h"
#include "bench/papers/table.h"
#include "lode/models/diamond/model.h"

namespace lode::bench {

/// The paper's table 1, preprocessing, and table 2, extraction with and without inheritance, with
/// ours beside it. Table 2 is split: what is counted, and what is timed.
class Tables12 {
 public:
  Tables12();

  void add_build(const PaperCase& paper_case, const Volume& volume);
  [[nodiscard]] Result<void> add_extractions(const PaperCase& paper_case, const Volume& volume);

  [[nodiscard]] const Table& preprocessing() const { return preprocessing_; }
  [[nodiscard]] const Table& counts() const { return counts_; }
  [[nodiscard]] const Table& times() const { return times_; }

 private:
  /// A query of a data set: a share of the nodes of full resolution.
  struct Step {
    const PaperCase& data;
    const PaperCase::Extraction& paper;
    const diamond::Model<3>& model;
    std::uint64_t most_nodes = 0;
  };

  /// Returns the largest error left.
  double add_counts(const Step& step);
  void add_times(const Step& step, double error_left);

  Table preprocessing_;
  Table counts_;
  Table times_;
};

}  // namespace lode::bench
