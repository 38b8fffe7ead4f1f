// Progress bar: one line on a terminal, nothing elsewhere; lines printed meanwhile stay whole.
#pragma once

#include <mutex>
#include <string>

namespace overcast {

/// Draws on stderr. All functions may be called from any thread.
class ProgressBar {
 public:
  explicit ProgressBar(bool wanted);  ///< draws when wanted and stderr is a terminal
  ~ProgressBar();                     ///< wipes the bar

  void update(double share);           ///< in [0, 1]
  void line(const std::string& text);  ///< prints a line above the bar, on any kind of stderr

 private:
  void wipe();

  std::mutex mutex_;
  bool draws_ = false;
  int shown_ = -1;  ///< percent on the screen, -1 when there is no bar
};

}  // namespace overcast
