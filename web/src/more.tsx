// The second file: all views.
export const views = {};
