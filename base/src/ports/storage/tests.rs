use super::*;

#[test]
fn files_have_the_date_only_when_somebody_has_set_it() {
    assert_eq!(FileTime::of(DateTime::UNSET), FileTime::NO_CLOCK);
    assert_eq!(FileTime::of(DateTime { year: 2026, ..DateTime::UNSET }).year, 2026);
}

#[test]
fn every_error_has_words_of_its_own() {
    use StorageError as E;
    let errors = [
        E::NotResponding,
        E::NotFound,
        E::Exists,
        E::WrongKind,
        E::BadPath,
        E::Full,
        E::DirectoryFull,
        E::Busy,
        E::ReadOnly,
        E::Damaged,
        E::TooManyOpen,
        E::Unsupported,
        E::Device,
    ];
    let texts: std::collections::BTreeSet<_> = errors.iter().map(|error| error.text()).collect();
    assert_eq!(texts.len(), errors.len());
    assert!(texts.iter().all(|text| text.len() > 8 && !text.ends_with('.')));
}
