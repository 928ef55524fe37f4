#include "verify_tetra.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "parse.h"
#include "tetra_input.h"
#include "vtk_import.h"

namespace lode::cli {
namespace {

constexpr std::int64_t kMostSteps = 1'000'000'000;

/// The mesh that a model was made from, with the model's fields, or those that are named.
struct Original {
  TetraMesh mesh;
  std::vector<std::size_t> fields;  ///< The model's.
};

Result<Original> read_original(const TetraVerifyJob& job, const TetraInfo& info, Session& session) {
  LODE_TRY(TetraOptions options, to_tetra_options(job.reading, is_field_of(info)));
  if (options.fields.empty())
    for (const TetraFieldInfo& field : info.fields)
      if (!field.time || info.fields.size() == 1) options.fields.push_back(field.name);
  if (options.fields.empty())
    return fail(
        "--against: expected --field to name one of {}, whose fields all have times, got "
        "none",
        job.input);
  Original original;
  const bool has_steps = std::ranges::any_of(info.fields, [&](const TetraFieldInfo& field) {
    return field.time && std::ranges::find(options.fields, field.name) != options.fields.end();
  });
  if (!job.reading.time.empty() && !has_steps && !may_have_steps(job.original))
    return fail("--time: expected none, as neither {} nor what is compared of {} has steps, got {}",
                job.original, job.input, job.reading.time);
  LODE_TRY(original.fields,
           named_fields(info, options.fields, has_steps ? job.reading.time : std::string()));
  // Of files that have steps that of the file, too.
  LODE_TRY(CellMesh cells, read_cells(job.original, job.reading, session));
  LODE_TRY(TetrahedraOutcome made, to_tetrahedra(std::move(cells), options));
  original.mesh = std::move(made.mesh);
  return original;
}

void append_checks(VerifyReport& report, VerifyReport more) {
  report.checks.insert(report.checks.end(), std::make_move_iterator(more.checks.begin()),
                       std::make_move_iterator(more.checks.end()));
}

}  // namespace

Result<void> check_tetra_verify(const TetraVerifyJob& job) {
  if (!job.original.empty() && !is_cells_path(job.original))
    return fail("--against: expected the mesh of cells that it was made from, got '{}'",
                job.original);
  if (is_lode_path(job.input) && job.original.empty() && !job.reading.is_empty())
    return fail("{}: expected no options of reading with a .lode file, got {}", job.input,
                job.reading.given());
  ReadingArguments reading = job.reading;
  // Also of an original without steps, that one step of a series was attached from.
  if (!job.original.empty() && !reading.time.empty()) {
    LODE_CHECK(parse_integer("--time", reading.time, 0, kMostSteps));
    reading.time.clear();
  }
  return check_tetra_reading(reading, job.original.empty() ? job.input : job.original);
}

Result<VerifyReport> verify_tetra(const TetraVerifyJob& job, Session& session) {
  VerifyReport report;
  if (is_lode_path(job.input)) {
    LODE_TRY(report, verify_every_byte(job.input, session.threads(), session.progress()));
  }
  ReadingArguments reading = job.reading;
  if (is_lode_path(job.input)) reading = {};  // the original's
  LODE_TRY(const TetraInput input, open_tetra_input(job.input, reading, session));
  const TetraDataset& dataset = input.dataset;
  LODE_TRY(
      VerifyReport more,
      dataset.verify({.is_exact = job.is_exact, .threads = session.threads()}, session.progress()));
  append_checks(report, std::move(more));
  if (job.original.empty()) return report;
  LODE_TRY(const Original original, read_original(job, dataset.describe(), session));
  LODE_TRY(VerifyReport compared,
           dataset.verify_against(original.mesh, original.fields, session.progress()));
  append_checks(report, std::move(compared));
  return report;
}

}  // namespace lode::cli
