// LandXML 1.2: one surface, a TIN, with points as "north east elevation". Units are those of the coordinate system,
// which GDAL tells, or metres when there is none.
#include <ctime>
#include <string>

#include "src/base/crs/survey_system.h"
#include "src/result/export/formats.h"
#include "src/result/export/stream_writer.h"

namespace tessera::exports {

namespace {

std::string utc(const char* format) {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  return {text, std::strftime(text, sizeof text, format, &parts)};
}

std::string units(const SurveySystem& system) {
  const std::string heights = system.vertical == LengthUnit::metre ? "meter" : "feet";
  const std::string more =
      " angularUnit=\"decimal degrees\" directionUnit=\"decimal degrees\" elevationUnit=\"" + heights + "\"/>";
  if (system.horizontal == LengthUnit::metre)
    return "<Metric areaUnit=\"squareMeter\" linearUnit=\"meter\" volumeUnit=\"cubicMeter\" "
           "temperatureUnit=\"celsius\" "
           "pressureUnit=\"milliBars\" diameterUnit=\"millimeter\"" +
           more;
  return std::string("<Imperial areaUnit=\"squareFoot\" linearUnit=\"") +
         (system.horizontal == LengthUnit::foot ? "foot" : "USSurveyFoot") +
         "\" volumeUnit=\"cubicYard\" temperatureUnit=\"fahrenheit\" pressureUnit=\"inchHG\" diameterUnit=\"inch\"" +
         more;
}

class LandXmlWriter : public StreamWriter {
 public:
  LandXmlWriter(OutputFile file, const MeshHead& head, const SurveySystem& system) : StreamWriter(std::move(file)) {
    stream_.text(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<LandXML xmlns=\"http://www.landxml.org/schema/LandXML-1.2\" "
        "version=\"1.2\" date=\"" +
        utc("%Y-%m-%d") + "\" time=\"" + utc("%H:%M:%S") + "\">\n<Units>" + units(system) + "</Units>\n");
    if (!system.wkt.empty()) {
      stream_.text("<CoordinateSystem desc=\"" + xml_text(system.title) + "\"");
      if (!system.epsg.empty()) stream_.text(" epsgCode=\"" + system.epsg + "\"");
      stream_.text(" ogcWktCode=\"" + xml_text(system.wkt) + "\"/>\n");
    }
    stream_.text("<Application name=\"tessera\" version=\"" + xml_text(head.software_version) +
                 "\"/>\n<Surfaces>\n<Surface name=\"TIN\">\n<Definition surfType=\"TIN\">\n<Pnts>\n");
  }

  void vertex(const VertexView& vertex) override {
    stream_.text("<P id=\"");
    stream_.digits(++vertices_);
    stream_.text("\">");
    stream_.digits(vertex.at.y);
    stream_.text(" ");
    stream_.digits(vertex.at.x);
    stream_.text(" ");
    stream_.digits(vertex.at.z);
    stream_.text("</P>\n");
  }
  void cell(const CellView& cell) override {
    begin_faces();
    stream_.text("<F>");
    for (std::size_t k = 0; k < 3; ++k) {
      if (k > 0) stream_.text(" ");
      stream_.digits(cell.numbers[k] + 1);
    }
    stream_.text("</F>\n");
  }

 private:
  void begin_faces() {
    if (!faces_) stream_.text("</Pnts>\n<Faces>\n");
    faces_ = true;
  }
  void end() override {
    begin_faces();
    stream_.text("</Faces>\n</Definition>\n</Surface>\n</Surfaces>\n</LandXML>\n");
  }
  std::uint64_t vertices_ = 0;
  bool faces_ = false;
};

}  // namespace

OpenedWriter open_landxml(const std::filesystem::path& path, const MeshHead& head) {
  BOOST_OUTCOME_TRY(system, survey_system(head.crs));
  BOOST_OUTCOME_TRY(file, OutputFile::create(path));
  return std::make_unique<LandXmlWriter>(std::move(file), head, system);
}

}  // namespace tessera::exports
