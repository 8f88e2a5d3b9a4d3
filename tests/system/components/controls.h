/* A text that would set the title of a terminal, start further escape sequences (U+009B, U+0090), reverse the
 * direction of the text (U+202E), and begin a new line. */
#define CONTROLS "<\x1b]0;title\x07\xc2\x9b" "31m\xc2\x90q\xe2\x80\xae>\r\nFORGED \t."
