#include "src/job/surface_arguments.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>

#include "src/job/arguments.h"
#include "src/surface/track/track.h"

namespace tessera {

Result<SensorOptions> parse_sensors(const std::string& text, bool files) {
  SensorOptions sensor;
  sensor.text = text;
  constexpr std::string_view point = "point:", track = "track:";
  if (text == "auto") return sensor;
  if (text == "vertical") {
    sensor.kind = SensorOptions::Kind::vertical;
  } else if (text == "scan-angle") {
    sensor.kind = SensorOptions::Kind::angles;
  } else if (text == "fields") {
    sensor.kind = SensorOptions::Kind::fields;
  } else if (files && text.starts_with(track)) {
    sensor.kind = SensorOptions::Kind::track;
    BOOST_OUTCOME_TRY(read, Track::read(text.substr(track.size())));
    sensor.track = std::make_shared<const Track>(std::move(read));
  } else if (text.starts_with(point)) {
    sensor.kind = SensorOptions::Kind::positions;
    for (std::size_t at = point.size(); at <= text.size();) {
      const std::size_t end = std::min(text.find(';', at), text.size());
      BOOST_OUTCOME_TRY(position, parse_point(text.substr(at, end - at), 3));
      sensor.positions.push_back(position);
      at = end + 1;
    }
  } else {
    return error(Errc::usage, "'" + text +
                                  "' does not say where the sensors are; give auto, vertical, fields, scan-angle, " +
                                  (files ? "track:FILE.csv or " : "or ") + "point:X,Y,Z;X,Y,Z;...");
  }
  return sensor;
}

Result<SurfaceOptions::Bottom> parse_bottom(const std::string& text) {
  if (text == "closed") return SurfaceOptions::Bottom::closed;
  if (text == "open") return SurfaceOptions::Bottom::open;
  if (text == "free") return SurfaceOptions::Bottom::free;
  return error(Errc::usage, "'" + text + "' is not a kind of bottom; give closed, open or free");
}

Result<bool> parse_unknown(const std::string& text) {
  if (text == "solid") return true;
  if (text == "empty") return false;
  return error(Errc::usage, "'" + text + "' is neither solid nor empty");
}

Result<double> parse_ray_length(const std::string& text) {
  if (text == "full") return std::numeric_limits<double>::infinity();
  return parse_distance(text);
}

Result<double> parse_sigma(const std::string& text) {
  if (text == "auto") return 0.0;
  return parse_distance(text);
}

}  // namespace tessera
