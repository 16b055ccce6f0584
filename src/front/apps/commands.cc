#include "src/front/apps/commands.h"

#include <CLI/CLI.hpp>
#include <string>

#include "src/front/apps/alpha.h"
#include "src/front/apps/help.h"
#include "src/front/apps/terrain_commands.h"
#include "src/front/apps/update_command.h"
#include "src/job/version.h"

namespace tessera::apps {

std::vector<Command> add_commands(CLI::App& root) {
  root.name("tessera");
  root.description("Exact Delaunay triangulation of point clouds that do not fit in memory.");
  root.set_version_flag("--version", std::string("tessera ") + version());
  root.formatter(help_formatter());  // before the commands are added, because they inherit it
  root.require_subcommand(1);
  root.footer(
      "'tessera help COMMAND' tells more. Options can also come from TESSERA_* variables and a file: see --config.");
  std::vector<Command> commands;
  commands.push_back(add_triangulate(root));
  commands.push_back(add_verify(root));
  commands.push_back(add_info(root));
  commands.push_back(add_export(root));
  commands.push_back(add_region(root));
  commands.push_back(add_query(root));
  commands.push_back(add_dem(root));
  commands.push_back(add_contours(root));
  commands.push_back(add_profile(root));
  commands.push_back(add_hag(root));
  commands.push_back(add_volume(root));
  commands.push_back(add_alpha(root));
  commands.push_back(add_surface(root));
  commands.push_back(add_track(root));
  commands.push_back(add_tileset(root));
  commands.push_back(add_materialise(root));
  commands.push_back(add_update(root));
  commands.push_back(add_log(root));
  commands.push_back(add_measure(root));
  commands.push_back(add_columns(root));
  commands.push_back(add_voronoi(root));
  commands.push_back(add_density(root));
  commands.push_back(add_voids(root));
  commands.push_back(add_certs(root));
  commands.push_back(add_cluster(root));
  commands.push_back(add_jobs(root));
  commands.push_back(add_job(root));
  commands.push_back(add_watch(root));
  commands.push_back(add_cancel(root));
  commands.push_back(add_resume(root));
  commands.push_back(add_inputs(root));
  commands.push_back(add_results(root));
  commands.push_back(add_fetch(root));
  commands.push_back(add_upload(root));
  commands.push_back(add_nodes(root));
  commands.push_back(add_drain(root));
  commands.push_back(add_generate(root));
  return commands;
}

}  // namespace tessera::apps
