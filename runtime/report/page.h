// Page: a report as one HTML file that needs no other file and no network.
#pragma once

#include <string>
#include <vector>

#include "formats/report.h"
#include "runtime/report/picture.h"

namespace overcast {

/// `pictures` holds those of each scene, in the order of the report. The same report and pictures give the same bytes.
std::string reportPage(const Report& report, const std::vector<std::vector<PagePicture>>& pictures);

}  // namespace overcast
