#pragma once

#include <string>
#include <vector>

#include "command.h"
#include "lode/api/probe.h"
#include "probe_options.h"
#include "text.h"

namespace lode::cli {

/// What `lode probe` has found, of one kind.
struct ProbeAnswer {
  ProbeReport report;
  std::vector<ProbedPoint> points;
  std::vector<ProbedLinePoint> line;
  std::optional<IntegralReport> integral;
  bool has_regions = false;         ///< Several.
  std::vector<std::string> with{};  ///< Names of further fields.
};

/// What a TetraDataset or a Dataset says.
template <typename Data>
Result<ProbeAnswer> answer_of(const Data& dataset, const ProbeJob& job, Progress& progress) {
  ProbeAnswer answer;
  switch (job.kind) {
    case ProbeKind::points: {
      LODE_TRY(answer.report, dataset.probe(job.points, job.options, answer.points, progress));
      break;
    }
    case ProbeKind::line: {
      LODE_TRY(answer.report, dataset.probe_line(job.line, job.options, answer.line, progress));
      break;
    }
    case ProbeKind::integral: {
      LODE_TRY(answer.integral, dataset.integrate(job.integral, progress));
      answer.report = answer.integral->probe;
    }
  }
  return answer;
}

/// What is to be known of an answer: points that are outside, and so on. `has_holes`: of the data.
void warn_of_answer(Session& session, const ProbeAnswer& answer, bool has_holes);

/// What holds for all rows, whatever was probed: tolerance and errors, counts and time.
void add_probe_rows(const ProbeAnswer& answer, Table& table);

/// Puts the head, and the rows of the answer, into an outcome.
void finish_probe(const ProbeAnswer& answer, const Table& head, double open_seconds,
                  const Session& session, Outcome& outcome);

/// Rows for people, in as many digits as tables have; for programs, that read numbers back as they
/// are; and to a file likewise, with a heading.
[[nodiscard]] std::string probe_table(const ProbeAnswer& answer);
[[nodiscard]] Json probe_json(const ProbeAnswer& answer);
[[nodiscard]] std::string probe_csv(const ProbeAnswer& answer);

}  // namespace lode::cli
