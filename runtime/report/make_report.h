// MakeReport: measures scenes and writes report.html, report.csv, report.json and the pictures.
#pragma once

#include <filesystem>
#include <vector>

#include "formats/report.h"
#include "runtime/report/choice.h"
#include "runtime/report/measure_scene.h"

namespace overcast {

struct ReportJob {
  std::vector<std::filesystem::path> scenes;  ///< baked; those of one file name are bakes of one scene, the first of them the scene's own
  std::filesystem::path reference;            ///< folder of the references of all, or of a folder for each
  std::filesystem::path output;
  MeasureSettings measure;
};

/// Measures and writes. Errors name the scene, reference or output at fault; errors of the device name no file.
Result<Report> makeReport(const Device& device, const ReportJob& job);

/// Chooses by `wish` for a scene of the report and writes the setting into its lighting, where it is not that already; nothing else in the
/// file changes, and constants that were fitted to another setting lose their fit error. Returns the row chosen, or null when none fits.
Result<const ReportRow*> applyWish(const ReportScene& scene, const std::filesystem::path& file, const Wish& wish);

}  // namespace overcast
