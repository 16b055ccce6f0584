// Prints the table of phases as JSON, for the build of the dashboard and for tests.
#include <cstdio>

#include "src/base/phases.h"

namespace tessera {
namespace {

// The name of a counter in the service's messages, and the word for the tiles that it counts.
struct CounterNames {
  const char* name;
  const char* tiles_are;
};

CounterNames names_of(ProgressCounter tiles) {
  if (tiles == ProgressCounter::tiles_stored) return {"tilesStored", "stored"};
  return {"tilesTriangulated", "triangulated"};
}

void print_row(const PhaseRow& row) {
  const CounterNames tiles = names_of(row.tiles);
  std::printf(R"({"name": "%s", "words": "%s", "over": %s, "tiles": "%s", "tilesAre": "%s"})", row.name, row.label,
              row.over ? "true" : "false", tiles.name, tiles.tiles_are);
}

}  // namespace
}  // namespace tessera

int main() {
  const char* before = "[";
  for (const tessera::PhaseRow& row : tessera::phase_table) {
    std::printf("%s\n ", before);
    tessera::print_row(row);
    before = ",";
  }
  std::printf("\n]\n");
}
