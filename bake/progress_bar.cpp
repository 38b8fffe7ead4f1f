#include "bake/progress_bar.h"

#include <unistd.h>

#include <algorithm>

#include <fmt/format.h>

#include "formats/console.h"

namespace overcast {

ProgressBar::ProgressBar(bool wanted) : draws_(wanted && ::isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  wipe();
}

void ProgressBar::update(double share) {
  const std::lock_guard lock(mutex_);
  const int percent = static_cast<int>(100.0 * std::clamp(share, 0.0, 1.0));
  if (!draws_ || percent == shown_) return;
  constexpr int kWidth = 40;
  const auto full = static_cast<std::size_t>(percent * kWidth / 100);
  printMessage(fmt::format("\r[{}{}] {:3d} %", std::string(full, '#'), std::string(kWidth - full, ' '), percent));
  shown_ = percent;
}

void ProgressBar::line(const std::string& text) {
  const std::lock_guard lock(mutex_);
  wipe();
  printMessage(oneLine(text) + "\n");
}

void ProgressBar::wipe() {
  if (shown_ < 0) return;
  printMessage("\r\033[K");
  shown_ = -1;
}

}  // namespace overcast
