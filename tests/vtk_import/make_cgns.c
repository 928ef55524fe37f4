/* Writes blocks.cgns, which make_fixtures.py cannot do without a library. By hand, once:
   cc make_cgns.c -o make_cgns -lcgns && ./make_cgns blocks.cgns && gzip -9n blocks.cgns
   (Debian's libcgns-dev 3.4.0). Two zones of 2 x 2 x 2 hexahedra over [0, 4] x [0, 2] x [0, 2]: one
   structured, one unstructured, with f = x + 2 y + 4 z at vertices, and a zone of a surface. */
#include <cgnslib.h>
#include <stdio.h>
#include <stdlib.h>

static void check(int status) {
  if (status == CG_OK) return;
  fprintf(stderr, "%s\n", cg_get_error());
  exit(1);
}

static void write_points(int file, int zone, double from, int dims[3]) {
  double x[27], y[27], z[27], f[27];
  int n = 0, flow = 0, field = 0, coordinate = 0;
  for (int k = 0; k < dims[2]; ++k)
    for (int j = 0; j < dims[1]; ++j)
      for (int i = 0; i < dims[0]; ++i, ++n) {
        x[n] = from + i;
        y[n] = j;
        z[n] = k;
        f[n] = x[n] + 2 * y[n] + 4 * z[n];
      }
  check(cg_coord_write(file, 1, zone, CGNS_ENUMV(RealDouble), "CoordinateX", x, &coordinate));
  check(cg_coord_write(file, 1, zone, CGNS_ENUMV(RealDouble), "CoordinateY", y, &coordinate));
  check(cg_coord_write(file, 1, zone, CGNS_ENUMV(RealDouble), "CoordinateZ", z, &coordinate));
  check(cg_sol_write(file, 1, zone, "Flow", CGNS_ENUMV(Vertex), &flow));
  check(cg_field_write(file, 1, zone, flow, CGNS_ENUMV(RealDouble), "f", f, &field));
}

int main(int argc, char** argv) {
  int file, base, zone, section;
  int cube[3] = {3, 3, 3}, sheet[3] = {3, 3, 1};
  cgsize_t structured[9] = {3, 3, 3, 2, 2, 2, 0, 0, 0}, unstructured[3] = {27, 8, 0};
  cgsize_t surface[3] = {9, 4, 0}, cells[64], quads[16];
  int n = 0;
  if (argc != 2) return 2;
  check(cg_set_file_type(CG_FILE_HDF5));
  check(cg_open(argv[1], CG_MODE_WRITE, &file));
  check(cg_base_write(file, "Base", 3, 3, &base));
  check(cg_zone_write(file, base, "Inlet", structured, CGNS_ENUMV(Structured), &zone));
  write_points(file, zone, 0, cube);
  check(cg_zone_write(file, base, "Outlet", unstructured, CGNS_ENUMV(Unstructured), &zone));
  write_points(file, zone, 2, cube);
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) {
        const int a = 1 + i + 3 * j + 9 * k;
        const int corners[8] = {a, a + 1, a + 4, a + 3, a + 9, a + 10, a + 13, a + 12};
        for (int c = 0; c < 8; ++c) cells[n++] = corners[c];
      }
  check(cg_section_write(file, base, zone, "Cells", CGNS_ENUMV(HEXA_8), 1, 8, 0, cells, &section));
  check(cg_zone_write(file, base, "Wall", surface, CGNS_ENUMV(Unstructured), &zone));
  write_points(file, zone, 0, sheet);
  n = 0;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const int a = 1 + i + 3 * j;
      quads[n++] = a, quads[n++] = a + 1, quads[n++] = a + 4, quads[n++] = a + 3;
    }
  check(cg_section_write(file, base, zone, "Faces", CGNS_ENUMV(QUAD_4), 1, 4, 0, quads, &section));
  check(cg_close(file));
  return 0;
}
