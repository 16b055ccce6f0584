// The style sheet of report.html, for light and dark themes, telephones, paper and wide screens.
#pragma once

#include <string>

namespace tessera {

std::string report_style();  // a <style> element

}  // namespace tessera
