#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace lode::fuzz {

using Input = std::span<const std::byte>;

/// One decoder each, given bytes that nobody vouches for. It may refuse them; it may not crash,
/// hang, take memory that they cannot justify, or break what it promises about what it accepts,
/// which ends the program. What each makes of the bytes stands in its source.
void run_lode_file(Input input);
void run_tetra_file(Input input);
void run_terrain_file(Input input);
void run_directory(Input input);
void run_index(Input input);
void run_codec(Input input);
void run_journal(Input input);
void run_part_log(Input input);
void run_nrrd(Input input);
void run_metaimage(Input input);
void run_nifti(Input input);
void run_vtk_legacy(Input input);
void run_vtk_xml(Input input);
void run_zarr_v2(Input input);
void run_zarr_v3(Input input);
void run_ome_zarr(Input input);
void run_ply(Input input);
void run_vtp(Input input);
void run_stl(Input input);
void run_obj(Input input);
void run_glb(Input input);
void run_camera(Input input);
void run_cell_mesh(Input input);
void run_medit_solution(Input input);
void run_points(Input input);
void run_quantized_mesh(Input input);
void run_tile_layer(Input input);

struct Harness {
  const char* name;  ///< Of its corpus, tests/fuzz/corpus/NAME, and its program, fuzz_NAME.
  void (*run)(Input input);
};

inline constexpr Harness kHarnesses[] = {
    {"lode_file", run_lode_file},
    {"tetra_file", run_tetra_file},
    {"terrain_file", run_terrain_file},
    {"directory", run_directory},
    {"index", run_index},
    {"codec", run_codec},
    {"journal", run_journal},
    {"part_log", run_part_log},
    {"nrrd", run_nrrd},
    {"metaimage", run_metaimage},
    {"nifti", run_nifti},
    {"vtk_legacy", run_vtk_legacy},
    {"vtk_xml", run_vtk_xml},
    {"zarr_v2", run_zarr_v2},
    {"zarr_v3", run_zarr_v3},
    {"ome_zarr", run_ome_zarr},
    {"ply", run_ply},
    {"vtp", run_vtp},
    {"stl", run_stl},
    {"obj", run_obj},
    {"glb", run_glb},
    {"camera", run_camera},
    {"cell_mesh", run_cell_mesh},
    {"medit_solution", run_medit_solution},
    {"points", run_points},
    {"quantized_mesh", run_quantized_mesh},
    {"tile_layer", run_tile_layer},
};

}  // namespace lode::fuzz
