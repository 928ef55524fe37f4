#pragma once

#include <string>
#include <vector>

#include "lode/core/place_polygon.h"
#include "lode/core/result.h"

namespace lode::io {

/// The polygons of a file of features.
struct PolygonFile {
  std::string path;
  std::vector<PlacePolygon> polygons;  ///< Of all features; rings have three corners or more.
  std::string crs;                     ///< As WKT; empty: not known.
};

/// Whether the name is that of a file of polygons: .geojson, .json, .gpkg or .shp (any case).
[[nodiscard]] bool is_polygon_path(const std::string& path);

/// Reads GeoJSON, a GeoPackage or a shapefile through GDAL: one layer of polygons and of several at
/// once; arcs become chords, and heights are left out. Fails, naming the file and the feature, on
/// anything else, also on features without a polygon.
[[nodiscard]] Result<PolygonFile> read_polygons(const std::string& path);

/// The polygons in the coordinates of another CRS, as WKT, or as they are where both are the same,
/// or neither is known. Fails, naming the file, where one alone is known, and on places that the
/// CRS has not. Edges, which are straight in the file's CRS, get corners every 64th of the
/// polygons' extent.
[[nodiscard]] Result<std::vector<PlacePolygon>> polygons_in(const PolygonFile& file,
                                                            const std::string& crs);

}  // namespace lode::io
