// PageParts: style and script of a report's page, the same in every report.
#pragma once

namespace overcast {

/// From the doctype to the start of the content.
extern const char* const kPageHead;

/// Shows the pictures of the setting that the pointer is on, or that was chosen, in the scene that holds it; the difference is made here,
/// of picture and reference. Tables are sorted by the column that is clicked. It reads what reportPage writes: `overcastPictures`, one
/// array of data URIs for each scene, the reference first, then one for each row; `overcastRange`, the difference that has its full colour.
extern const char* const kPageScript;

}  // namespace overcast
