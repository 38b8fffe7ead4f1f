// Chart: settings of a scene as dots over two logarithmic axes, as SVG to put into a page.
#pragma once

#include <string>
#include <vector>

#include "formats/report.h"
#include "runtime/report/choice.h"

namespace overcast {

/// `text` with what HTML would read as markup written as entities.
std::string escapedHtml(const std::string& text);

/// What the marks of a row are called in the legend: the estimator, or the technique; "apertures" for estimators that a scene's apertures
/// stand in for.
std::string familyOf(const ReportRow& row);

/// The mark of a family, of about 12 pixels about (x, y), as SVG. Ours are coloured discs (Okabe and Ito's colours, which people tell apart
/// who see few), the others grey shapes, each its own.
std::string markOf(const ReportRow& row, double x, double y);
/// Its colour.
std::string colourOf(const ReportRow& row);

/// RMSE (called `error` on its axis) against `cost`: a mark for each row, whose number among the rows is its attribute data-row, with a
/// title that tells its settings and figures; lines join the resolutions of what is otherwise one setting; the front as a dashed line, its
/// marks named where there is room. An <svg> element.
std::string tradeoffChart(const ReportScene& scene, Cost cost, const std::string& error);

/// A setting and its figures, line by line.
std::string describedRow(const ReportRow& row);

/// Bars that tell, of each row that has steps, the signed share of its mean square error that each step makes. An <svg> element.
std::string stepsChart(const ReportScene& scene);

}  // namespace overcast
