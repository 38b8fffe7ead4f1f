// Height files as other programs write them, made without our readers: through libpng, OpenEXR, and by the letter of the text formats.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace overcast::test {

/// Heights by row (from the north) and column (from the west); NaN: none.
struct Heights {
  int columns = 0;
  int rows = 0;
  std::vector<double> values;

  Heights(int width, int height, const std::function<double(int, int)>& of);  ///< of(column, row)
  double at(int column, int row) const { return values[static_cast<std::size_t>(row * columns + column)]; }
};

/// Grey of 16 bits, `high` - `low` over 65535 steps; without value: alpha 0 (`alpha`), else 0.
void writeHeightPng(const std::filesystem::path& path, const Heights& heights, double low, double high, bool alpha = false,
                    bool interlaced = false);

void writeHeightExr(const std::filesystem::path& path, const Heights& heights, const char* channel = "Y");

/// Decimals: digits behind the point. Corner and cell as given.
std::string esriText(const Heights& heights, double cell, double mark = -9999.0, double left = 500.0, double bottom = 7000.0);

/// Ground and height units by their codes; a profile starts and ends with its first and last value.
struct UsgsSettings {
  int groundUnit = 2;
  int heightUnit = 2;
  double step = 30.0;  ///< ground units
  double heightStep = 1.0;
  double left = 500000.0, bottom = 4000000.0;
  bool lines = false;  ///< every block ends a line and trailing blanks are gone
};
std::string usgsText(const Heights& heights, const UsgsSettings& settings);

}  // namespace overcast::test
