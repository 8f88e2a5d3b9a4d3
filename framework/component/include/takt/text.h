/* One sentence that says what a component does, for `takt describe`. At file scope, once in a component:
 *
 *   TAKT_TEXT("Keeps an extruder's heating zone at its temperature.");
 *
 * For every form: a module in C, a program, also one that calls nothing of Takt. It lies in a section of its
 * own in the file, so it is read without loading or starting what the file holds. A component in C++ says it
 * in TAKT_COMPONENT. */
#ifndef TAKT_TEXT_H
#define TAKT_TEXT_H

#define TAKT_TEXT(words) \
  static const char takt_text_of_this[] __attribute__((used, section("takt_text"))) = words

#endif
