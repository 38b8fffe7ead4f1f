#include "tests/formats/terrain_files.h"

#include <cmath>
#include <cstdio>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <fmt/format.h>
#include <png.h>

namespace overcast::test {
namespace {

std::string fortran(double value) {
  std::string text = fmt::format("{:24.15E}", value);
  text[text.find('E')] = 'D';
  return text;
}

}  // namespace

Heights::Heights(int width, int height, const std::function<double(int, int)>& of) : columns(width), rows(height) {
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) values.push_back(of(column, row));
}

void writeHeightPng(const std::filesystem::path& path, const Heights& heights, double low, double high, bool alpha, bool interlaced) {
  const std::size_t step = alpha ? 4 : 2;
  std::vector<png_byte> bytes;
  for (const double h : heights.values) {
    const auto value = std::isnan(h) ? 0u : static_cast<unsigned>(std::lround((h - low) / (high - low) * 65535.0));
    bytes.insert(bytes.end(), {static_cast<png_byte>(value >> 8), static_cast<png_byte>(value & 255)});
    if (alpha) bytes.insert(bytes.end(), 2, std::isnan(h) ? png_byte{0} : png_byte{255});
  }
  std::vector<png_bytep> rows;
  for (int row = 0; row < heights.rows; ++row) rows.push_back(bytes.data() + static_cast<std::size_t>(row * heights.columns) * step);
  std::FILE* file = std::fopen(path.c_str(), "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, static_cast<png_uint_32>(heights.columns), static_cast<png_uint_32>(heights.rows), 16,
               alpha ? PNG_COLOR_TYPE_GRAY_ALPHA : PNG_COLOR_TYPE_GRAY, interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_gAMA(png, info, 0.45455);  // as paint programs add it; heights must not follow it
  png_write_info(png, info);
  png_write_image(png, rows.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

void writeHeightExr(const std::filesystem::path& path, const Heights& heights, const char* channel) {
  std::vector<float> values(heights.values.begin(), heights.values.end());
  Imf::Header header(heights.columns, heights.rows);
  header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
  Imf::FrameBuffer frame;
  frame.insert(channel, Imf::Slice::Make(Imf::FLOAT, values.data(), header.dataWindow(), sizeof(float),
                                         sizeof(float) * static_cast<std::size_t>(heights.columns)));
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(frame);
  file.writePixels(heights.rows);
}

std::string esriText(const Heights& heights, double cell, double mark, double left, double bottom) {
  std::string text = fmt::format("NCOLS {}\r\nnrows {}\r\nXLLCORNER {}\r\nyllCorner {}\r\ncellsize {}\r\nNODATA_value {}\r\n",
                                 heights.columns, heights.rows, left, bottom, cell, mark);
  for (int row = 0; row < heights.rows; ++row) {
    for (int column = 0; column < heights.columns; ++column)
      text += fmt::format("{} ", std::isnan(heights.at(column, row)) ? mark : heights.at(column, row));
    text += "\r\n";
  }
  return text;
}

std::string usgsText(const Heights& heights, const UsgsSettings& settings) {
  std::string text;
  const auto pad = [&] { text.append((1024 - text.size() % 1024) % 1024, ' '); };
  text = fmt::format("{:<144}{:6}{:6}{:6}{:6}", "A TEST OF PROFILES", 1, 1, 1, 10);
  for (int i = 0; i < 15; ++i) text += fortran(0.0);
  text += fmt::format("{:6}{:6}{:6}", settings.groundUnit, settings.heightUnit, 4);
  for (int i = 0; i < 11; ++i) text += fortran(0.0);
  text += fmt::format("{:6}{:12.6E}{:12.6E}{:12.6E}{:6}{:6}", 1, settings.step, settings.step, settings.heightStep, 1, heights.columns);
  pad();
  for (int column = 0; column < heights.columns; ++column) {
    int top = 0, bottom = heights.rows - 1;
    while (std::isnan(heights.at(column, top))) ++top;
    while (std::isnan(heights.at(column, bottom))) --bottom;
    text += fmt::format("{:6}{:6}{:6}{:6}", 1, column + 1, bottom - top + 1, 1);
    text += fortran(settings.left + settings.step * column);
    text += fortran(settings.bottom + settings.step * (heights.rows - 1 - bottom));
    for (int i = 0; i < 3; ++i) text += fortran(0.0);
    for (int row = bottom; row >= top; --row) {
      if (text.size() % 1024 == 1020) pad();
      const double h = heights.at(column, row);
      text += fmt::format("{:6}", std::isnan(h) ? -32767 : std::lround(h / settings.heightStep));
    }
    pad();
  }
  if (!settings.lines) return text;
  std::string lines;
  for (std::size_t i = 0; i < text.size(); i += 1024) {
    const std::string block = text.substr(i, 1024);
    lines += block.substr(0, block.find_last_not_of(' ') + 1) + "\n";
  }
  return lines;
}

}  // namespace overcast::test
