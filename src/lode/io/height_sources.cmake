# Reading heights; included by CMakeLists.txt beside it.
set(IO_HEIGHT_SOURCES
  ascii_grid.cpp
  child_program.cpp
  covered_area.cpp
  crs_map.cpp
  crs_metric.cpp
  gdal_crs.cpp
  gdal_library.cpp
  gdal_raster.cpp
  height_band.cpp
  height_formats.cpp
  height_hgt.cpp
  height_stream.cpp
  height_reader.cpp
  height_transform.cpp
  las_crs.cpp
  point_las.cpp
  point_reader.cpp
  point_text.cpp
  line_file.cpp
  imported_raster.cpp
  polygon_file.cpp
  vector_input.cpp
  proj_library.cpp
  quantized_mesh.cpp
  quantized_mesh_input.cpp
  raster_file.cpp
  degrees_rim.cpp
  raster_warp.cpp
  resampling_error.cpp
  vector_file.cpp
  vertical_crs.cpp
  virtual_raster.cpp
  virtual_sources.cpp)

# GDAL is loaded by its name when it is needed: linked, it would triple the time to start.
find_package(GDAL REQUIRED)
get_target_property(LODE_GDAL_HEADERS GDAL::GDAL INTERFACE_INCLUDE_DIRECTORIES)
file(REAL_PATH ${GDAL_LIBRARY} LODE_GDAL_FILE)
get_filename_component(LODE_GDAL_NAME ${LODE_GDAL_FILE} NAME)
string(REGEX MATCH "^libgdal\\.so\\.[0-9]+" LODE_GDAL_NAME ${LODE_GDAL_NAME})

# So is PROJ, which GDAL brings.
pkg_check_modules(LODE_PROJ REQUIRED proj)
find_library(LODE_PROJ_LINK proj REQUIRED HINTS ${LODE_PROJ_LIBRARY_DIRS})
file(REAL_PATH ${LODE_PROJ_LINK} LODE_PROJ_FILE)
get_filename_component(LODE_PROJ_NAME ${LODE_PROJ_FILE} NAME)
string(REGEX MATCH "^libproj\\.so\\.[0-9]+" LODE_PROJ_NAME ${LODE_PROJ_NAME})
