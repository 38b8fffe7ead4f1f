// Fuzzes the reader of report.json: what it accepts it must write so that it is accepted again, as the same.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "formats/report.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto report = overcast::parseReport(std::string_view(reinterpret_cast<const char*>(data), size), "");
  if (!report) return 0;
  const std::string written = overcast::reportJson(report.value());
  const auto again = overcast::parseReport(written, "");
  if (!again || overcast::reportJson(again.value()) != written) std::abort();
  return 0;
}
