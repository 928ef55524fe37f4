#include "bench/papers/cases.h"

#include "tests/oracles/hydrogen_atom.h"

namespace lode::bench {

// Isovalues are ours, the paper names none: the closed lobes that its figures show.
std::vector<PaperCase> paper_cases() {
  std::vector<PaperCase> cases;
  cases.push_back({.name = "neghip 66³",
                   .paper = "Hipip 64³",
                   .volume = {.name = "neghip",
                              .file = "neghip_66x66x66_uint8.raw",
                              .raw_dims = Index3{{66, 66, 66}},
                              .isovalue = 50.5},
                   .build_s = 3.9,
                   .extractions = {{0.6, 0.1, 0.3}, {0.85, 0.4, 1.0}, {1, 0.9, 2.5}}});
  cases.push_back({.name = "hydrogen atom 128³",
                   .paper = "Idrogen-Atom 128³",
                   .volume = {.name = "hydrogen_atom", .n = 128, .isovalue = 25.5},
                   .build_s = 10.5,
                   .extractions = {{0.6, 0.4, 1.0}, {0.85, 1.5, 4.6}, {1, 3.9, 11.7}}});
  cases.push_back(
      {.name = "bonsai 256³",
       .paper = "Bonsai 256³",
       .volume = {.name = "bonsai", .file = "bonsai_256x256x256_uint8.nrrd", .isovalue = 40.5},
       .build_s = 32.65,
       .extractions = {{0.6, 0, 0}, {0.85, 0, 0}, {1, 0, 0}}});
  return cases;
}

Result<Volume> load(const PaperCase& paper_case) {
  if (paper_case.volume.file.empty()) return oracles::hydrogen_atom(paper_case.volume.n);
  return load(paper_case.volume);
}

}  // namespace lode::bench
