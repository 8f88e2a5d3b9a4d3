/** @file
 * The description of a component in one sentence, for `takt describe`. At file scope, once in a component:
 *
 *     TAKT_TEXT("Keeps an extruder's heating zone at its temperature.");
 *
 * It works in every form: in a module in C, and in a program, even one that does not use Takt otherwise. The
 * sentence is in a separate section of the file, so `takt describe` reads it without loading or starting the
 * file. A component in C++ passes the sentence to TAKT_COMPONENT. */
#ifndef TAKT_TEXT_H
#define TAKT_TEXT_H

/** Describes the component in one sentence, a string literal. At file scope, once. */
#define TAKT_TEXT(words) \
  static const char takt_text_of_this[] __attribute__((used, section("takt_text"))) = words

#endif
