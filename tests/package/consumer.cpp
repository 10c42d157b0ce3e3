#include <cstdio>

#include <relief/io/mesh_io.h>
#include <relief/io/project_io.h>
#include <relief/reconstruction/reconstruct.h>

int main(int, char** argv) {
  const auto fail = [](const relief::Error& error) { return std::puts(error.message.c_str()), 1; };
  const auto project = relief::read_project(argv[1]);
  if (!project) return fail(project.error());
  const auto result = relief::reconstruction::reconstruct(project->views);
  if (!result) return fail(result.error());
  const auto written = relief::write_mesh(result->model.mesh, argv[2]);
  if (!written) return fail(written.error());
  const relief::MeshCheck& check = result->model.check;
  std::printf("%zu faces, watertight: %d\n", check.faces, check.watertight());
}
