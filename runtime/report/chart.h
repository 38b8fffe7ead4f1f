// Chart: settings of a scene as dots over two logarithmic axes, as SVG to put into a page.
#pragma once

#include <string>
#include <vector>

#include "formats/report.h"
#include "runtime/report/choice.h"

namespace overcast {

/// `text` with what HTML would read as markup written as entities.
std::string escapedHtml(const std::string& text);

/// What the dots of a row are called in the legend: the estimator (", with apertures"), or the technique.
std::string familyOf(const ReportRow& row);
/// A colour for each family, the same for the same name in any report.
std::string colourOf(const std::string& family);

/// RMSE against `cost`: dots, filled where the scene's lighting can say the setting, with a title that tells its settings and figures; the
/// front as a line; bars over the noise of times. An <svg> element.
std::string tradeoffChart(const ReportScene& scene, Cost cost);

}  // namespace overcast
