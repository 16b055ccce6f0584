#include "src/base/crs/geotiff.h"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <system_error>
#include <vector>

#include "src/base/crs/gdal_library.h"

namespace tessera {
namespace {

// A TIFF of one pixel with the given keys. Keys can say the same system in many ways, and GDAL knows all of them.
class TinyTiff {
 public:
  explicit TinyTiff(const GeoTiffKeys& keys) {
    const std::uint16_t count = static_cast<std::uint16_t>(10 + !keys.doubles.empty() + !keys.ascii.empty());
    values_at_ = 8 + 2 + 12 * std::size_t{count} + 4;
    put(std::uint16_t{0x4949});  // little endian
    put(std::uint16_t{42});
    put(std::uint32_t{8});  // where the directory stands
    put(count);
    number(256, 1);  // width
    number(257, 1);  // height
    number(258, 8);  // bits a sample
    number(259, 1);  // not compressed
    number(262, 1);  // black is zero
    number(273, 8);  // the pixel: any byte
    number(277, 1);  // samples a pixel
    number(278, 1);  // rows a strip
    number(279, 1);  // bytes a strip
    field(34735, 3, 2, keys.directory);
    if (!keys.doubles.empty()) field(34736, 12, 8, keys.doubles);
    if (!keys.ascii.empty()) field(34737, 2, 1, keys.ascii);
    put(std::uint32_t{0});  // no other directory
    bytes_.insert(bytes_.end(), values_.begin(), values_.end());
  }

  std::vector<unsigned char>& bytes() { return bytes_; }

 private:
  template <class T>
  void put(T value) {
    const auto* at = reinterpret_cast<const unsigned char*>(&value);
    bytes_.insert(bytes_.end(), at, at + sizeof value);
  }
  void number(std::uint16_t tag, std::uint16_t value) {
    constexpr std::uint16_t short_type = 3;
    put(tag);
    put(short_type);
    put(std::uint32_t{1});
    put(std::uint32_t{value});
  }
  void field(std::uint16_t tag, std::uint16_t type, std::size_t size, std::span<const std::byte> value) {
    const std::size_t count = value.size() / size;
    put(tag);
    put(type);
    put(static_cast<std::uint32_t>(count));
    if (count * size <= 4) {
      std::uint32_t inside = 0;
      std::memcpy(&inside, value.data(), count * size);
      return put(inside);
    }
    put(static_cast<std::uint32_t>(values_at_ + values_.size()));
    const auto* at = reinterpret_cast<const unsigned char*>(value.data());
    values_.insert(values_.end(), at, at + count * size);
    values_.resize((values_.size() + 7) / 8 * 8);
  }

  std::size_t values_at_ = 0;
  std::vector<unsigned char> bytes_, values_;
};

// A file in memory of GDAL, with a name of its own until destroyed.
class MemoryFile {
 public:
  MemoryFile(const GdalLibrary& gdal, std::vector<unsigned char>& bytes) : gdal_(gdal) {
    static std::atomic<std::uint64_t> next{0};
    name_ = "/vsimem/tessera-" + std::to_string(next++) + ".tif";
    VSILFILE* file = gdal_.VSIFileFromMemBuffer(name_.c_str(), bytes.data(), bytes.size(), FALSE);
    if (file != nullptr) gdal_.VSIFCloseL(file);
  }
  ~MemoryFile() { gdal_.VSIUnlink(name_.c_str()); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  const std::string& name() const { return name_; }

 private:
  const GdalLibrary& gdal_;
  std::string name_;
};

// Returns the WKT that GDAL makes of the keys. `source` is "GEOKEYS" for the keys' own parameters, or null for GDAL's
// choice: then a code's name counts, whatever else the keys say.
Result<std::string> read_keys(const GdalLibrary& gdal, std::vector<unsigned char>& bytes, const char* source) {
  gdal.CPLSetThreadLocalConfigOption("GTIFF_REPORT_COMPD_CS", "YES");
  gdal.CPLSetThreadLocalConfigOption("GTIFF_SRS_SOURCE", source);
  const MemoryFile file(gdal, bytes);
  const char* const drivers[] = {"GTiff", nullptr};
  const GDALDatasetH tiff = gdal.GDALOpenEx(file.name().c_str(), GDAL_OF_RASTER, drivers, nullptr, nullptr);
  std::string wkt;
  if (tiff != nullptr) {
    const char* text = gdal.GDALGetProjectionRef(tiff);
    wkt = text != nullptr ? text : "";
    gdal.GDALClose(tiff);
  }
  gdal.CPLSetThreadLocalConfigOption("GTIFF_REPORT_COMPD_CS", nullptr);
  gdal.CPLSetThreadLocalConfigOption("GTIFF_SRS_SOURCE", nullptr);
  if (wkt.empty()) return error(Errc::bad_input, "GDAL cannot make a coordinate system of the keys");
  return wkt;
}

std::optional<double> parse_metres(const std::string& text) {
  double metres = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), metres);
  return code == std::errc() && end == text.data() + text.size() ? std::optional(metres) : std::nullopt;
}

// Whether a system is what its code says. True for a system without a code.
bool says_its_code(const GdalLibrary& gdal, OGRSpatialReferenceH reference) {
  const std::string code = epsg_code(gdal, reference);
  if (code.empty()) return true;
  const auto meant = SpatialReference::parse(gdal, "EPSG:" + code);
  return meant && equivalent(gdal, reference, meant.value().get());
}

constexpr std::uint16_t vertical_key = 4096, vertical_unit_key = 4099;
constexpr std::size_t key_bytes = 8;  // the key's id, where its value is, how many values, the value

// The whole entries of a directory behind its header.
std::span<const std::byte> entries_of(std::span<const std::byte> directory) {
  const auto all = directory.subspan(key_bytes);
  return all.first(all.size() / key_bytes * key_bytes);
}

std::uint16_t id_of(std::span<const std::byte> entries, std::size_t at) {
  std::uint16_t id = 0;
  std::memcpy(&id, entries.data() + at, sizeof id);
  return id;
}

bool has_key(const GeoTiffKeys& keys, std::uint16_t id) {
  const auto entries = entries_of(keys.directory);
  for (std::size_t at = 0; at < entries.size(); at += key_bytes)
    if (id_of(entries, at) == id) return true;
  return false;
}

// GDAL reads WKT in a citation ("ESRI PE String = ..."), and such WKT may name files (wkt.h). Citations are meant for
// people. So citations that may contain WKT lose their slashes.
std::vector<std::byte> without_paths(std::span<const std::byte> ascii) {
  std::vector<std::byte> text(ascii.begin(), ascii.end());
  if (std::find(text.begin(), text.end(), std::byte{'='}) == text.end()) return text;
  for (auto& c : text)
    if (c == std::byte{'/'} || c == std::byte{'\\'}) c = std::byte{'_'};
  return text;
}

// The directory without the key `id`.
std::vector<std::byte> without_key(const GeoTiffKeys& keys, std::uint16_t id) {
  const auto entries = entries_of(keys.directory);
  std::vector<std::byte> directory(keys.directory.begin(), keys.directory.begin() + key_bytes);
  for (std::size_t at = 0; at < entries.size(); at += key_bytes)
    if (id_of(entries, at) != id)
      directory.insert(directory.end(), entries.data() + at, entries.data() + at + key_bytes);
  const auto count = static_cast<std::uint16_t>(directory.size() / key_bytes - 1);
  std::memcpy(directory.data() + 6, &count, sizeof count);
  return directory;
}

// Corrects the unit of heights. GDAL takes this unit from the code of the vertical system, whatever the key of the unit
// says. 5703 is in metres, but surveys in feet name it all the same. GDAL shows what the key means when the key stands
// alone.
Result<std::string> with_unit_of_heights(const GdalLibrary& gdal, const GeoTiffKeys& keys, const std::string& wkt) {
  if (!has_key(keys, vertical_key) || !has_key(keys, vertical_unit_key)) return wkt;
  BOOST_OUTCOME_TRY(reference, SpatialReference::parse(gdal, wkt));
  const auto directory = without_key(keys, vertical_key);
  TinyTiff tiff({directory, keys.doubles, keys.ascii});
  BOOST_OUTCOME_TRY(unit_wkt, read_keys(gdal, tiff.bytes(), nullptr));
  BOOST_OUTCOME_TRY(of_unit, SpatialReference::parse(gdal, unit_wkt));
  const auto value = [&](const SpatialReference& system, const char* path, int child = 0) -> std::string {
    const char* text = gdal.OSRGetAttrValue(system.get(), path, child);
    return text != nullptr ? text : "";
  };
  const auto metres = parse_metres(value(reference, "VERT_CS|UNIT", 1));
  const auto meant = parse_metres(value(of_unit, "VERT_CS|UNIT", 1));
  if (!metres || !meant || std::abs(*metres - *meant) < 1e-9) return wkt;
  constexpr int orthometric = 2005;  // GDAL's value where no other is given
  const auto name = value(reference, "VERT_CS"), datum = value(reference, "VERT_DATUM");
  const auto unit = value(of_unit, "VERT_CS|UNIT");
  const auto contradicts = [] {
    return error(Errc::bad_input, "the unit of the heights contradicts the coordinate system of the heights");
  };
  // A new unit would keep the old code. So the vertical system is first replaced by one with the same datum and no
  // code.
  gdal.OSRStripVertical(reference.get());
  if (gdal.OSRSetVertCS(reference.get(), name.c_str(), datum.c_str(), orthometric) != OGRERR_NONE ||
      gdal.OSRSetTargetLinearUnits(reference.get(), "VERT_CS", unit.c_str(), *meant) != OGRERR_NONE)
    return contradicts();
  char* text = nullptr;
  const bool written = gdal.OSRExportToWkt(reference.get(), &text) == OGRERR_NONE;
  const std::string corrected = written ? text : "";
  gdal.VSIFree(text);
  if (!written) return contradicts();
  return corrected;
}

}  // namespace

Result<std::string> crs_of(const GeoTiffKeys& given) {
  if (given.directory.size() < 8 || given.directory.size() > 8 * std::size_t{0xFFFF}) {
    return error(Errc::bad_input, "the directory of keys is missing or too large");
  }
  BOOST_OUTCOME_TRY(gdal, gdal_library());
  const GdalQuiet quiet(*gdal);
  const auto ascii = without_paths(given.ascii);
  const GeoTiffKeys keys{given.directory, given.doubles, ascii};
  TinyTiff tiff(keys);
  BOOST_OUTCOME_TRY(wkt, read_keys(*gdal, tiff.bytes(), nullptr));
  BOOST_OUTCOME_TRY(reference, SpatialReference::parse(*gdal, wkt));
  if (gdal->OSRIsLocal(reference.get()) != 0) return error(Errc::bad_input, "the keys name no coordinate system");
  if (gdal->OSRIsCompound(reference.get()) != 0) {
    BOOST_OUTCOME_TRY(horizontal, SpatialReference::parse(*gdal, wkt));
    gdal->OSRStripVertical(horizontal.get());
    if (says_its_code(*gdal, horizontal.get())) return with_unit_of_heights(*gdal, keys, wkt);
  } else if (says_its_code(*gdal, reference.get())) {
    const std::string code = epsg_code(*gdal, reference.get());
    return code.empty() ? wkt : "EPSG:" + code;
  }
  BOOST_OUTCOME_TRY(own, read_keys(*gdal, tiff.bytes(), "GEOKEYS"));
  return with_unit_of_heights(*gdal, keys, own);
}

}  // namespace tessera
