#include "src/base/crs/storage_crs.h"

#include <string_view>

#include "src/base/crs/crs.h"
#include "src/base/crs/gdal_library.h"

namespace tessera {

Result<StorageCrs> storage_crs(const std::string& crs) {
  constexpr std::string_view epsg = "urn:ogc:def:crs:EPSG::";
  BOOST_OUTCOME_TRY(name, crs_name_or_wkt(crs));
  if (!name.starts_with(epsg)) return StorageCrs{};
  const std::string code = name.substr(epsg.size());
  BOOST_OUTCOME_TRY(gdal, gdal_library());
  // The definition of the code counts, because the given text may have another order of axes.
  BOOST_OUTCOME_TRY(defined, SpatialReference::parse(*gdal, "EPSG:" + code));
  const GdalQuiet quiet(*gdal);
  const bool swapped =
      gdal->OSREPSGTreatsAsLatLong(defined.get()) != 0 || gdal->OSREPSGTreatsAsNorthingEasting(defined.get()) != 0;
  return StorageCrs{"http://www.opengis.net/def/crs/EPSG/0/" + code, swapped};
}

}  // namespace tessera
