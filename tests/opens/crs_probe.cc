// crs_probe FILE: does everything that src/base/crs does with each of the texts in FILE, which zeros separate. Before
// the text i the program asks whether the file /text/i exists, by which who watches it knows where it is. Prints one
// line a text: "taken" or "refused".
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "src/base/crs/crs.h"
#include "src/base/crs/geotiff.h"
#include "src/base/crs/lon_lat.h"
#include "src/base/crs/storage_crs.h"
#include "src/base/crs/survey_system.h"

namespace {

// As citations of GeoTIFF keys, in which GDAL reads WKT.
void as_citation(const std::string& text) {
  const std::string ascii = "ESRI PE String = " + text + "|";
  const auto length = static_cast<std::uint16_t>(ascii.size());
  std::vector<std::uint16_t> directory{1, 1, 0, 6, 1024, 0, 1, 32767, 3072, 0, 1, 32767};
  for (const std::uint16_t citation : {1026, 2049, 3073, 4097})
    directory.insert(directory.end(), {citation, 34737, length, 0});
  static_cast<void>(
      tessera::crs_of({std::as_bytes(std::span(directory)), {}, std::as_bytes(std::span(ascii.data(), ascii.size()))}));
}

void use(const std::string& text) {
  static_cast<void>(tessera::check_crs(text));
  static_cast<void>(tessera::crs_title(text));
  static_cast<void>(tessera::has_heights(text));
  static_cast<void>(tessera::same_crs(text, "EPSG:2154"));
  static_cast<void>(tessera::crs_name_or_wkt(text));
  static_cast<void>(tessera::storage_crs(text));
  static_cast<void>(tessera::survey_system(text));
  if (const auto places = tessera::LonLat::of(text)) {
    std::vector<tessera::Point> points{{-70, 45, 0}, {500000, 5000000, 0}};
    static_cast<void>(places.value().to(points));
    static_cast<void>(places.value().from(points));
  }
  as_citation(text);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::ifstream file(argv[1], std::ios::binary);
  const std::string all((std::istreambuf_iterator<char>(file)), {});
  std::size_t number = 0;
  for (std::size_t at = 0; at < all.size(); ++number) {
    const auto end = std::min(all.find('\0', at), all.size());
    const std::string text = all.substr(at, end - at);
    at = end + 1;
    static_cast<void>(::access(("/text/" + std::to_string(number)).c_str(), F_OK));
    use(text);
    std::puts(tessera::looks_like_crs(text) ? "taken" : "refused");
  }
}
