// Table: a report as Markdown for people and as CSV for spreadsheets.
#pragma once

#include <string>

#include "formats/report.h"
#include "runtime/report/choice.h"

namespace overcast {

/// Two Markdown tables, of settings over all scenes and of scenes, and where another technique wins. Ends with a line break.
std::string summaryMarkdown(const Report& report);

/// One line for each row of each scene under a line of names (RFC 4180); an absent figure is an empty field.
std::string reportCsv(const Report& report);

/// A loss in words, and in how many scenes we come out ahead, in one sentence.
std::string lossText(const Loss& loss);
std::string standingText(const Report& report, Cost cost);

}  // namespace overcast
