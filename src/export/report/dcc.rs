//! The certificate for machines: a Digital Calibration Certificate, XML as the Physikalisch-Technische Bundesanstalt defines it (schema
//! 3.1.2, with quantities in D-SI 2.1).
//!
//! Guarantees: what the schema requires and nobody entered is asked for by name; no element is invented.

use jiff::civil::Date;

use super::ReportData;
use super::markup::Markup;
use crate::calibration::{Calibration, LinearMap};
use crate::evaluation::limits::Verdict;
use crate::evaluation::uncertainty::COVERAGE_FACTOR;
use crate::recording::{Axis, Item};

const SCHEMA: &str = "3.1.2";
/// What it cannot be without.
const NEEDED: [Item; 6] = [
    Item::Certificate,
    Item::Serial,
    Item::Laboratory,
    Item::Country,
    Item::Date,
    Item::Operator,
];
const NOT_STATED: &str = "not stated";

/// Why there is no such certificate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum DccError {
    #[error("a machine-readable certificate needs {}; enter them in sensor.toml or in the window", .0.join(", "))]
    Missing(Vec<&'static str>),
    #[error("the date {0:?} is not one like 2026-03-31")]
    Date(String),
    #[error("the country {0:?} is not one of two letters (ISO 3166-1), like DE")]
    Country(String),
    #[error("no uncertainty is stated: {0}")]
    NoUncertainty(String),
}

/// The certificate as XML.
///
/// # Errors
/// [`DccError`] where something that it needs is not known.
pub(crate) fn dcc_of(report: &ReportData) -> Result<String, DccError> {
    let calibration = &report.calibration;
    let identity = &calibration.identity;
    let missing = NEEDED
        .into_iter()
        .filter(|item| identity.get(*item).trim().is_empty());
    let missing: Vec<&str> = missing.map(Item::key).collect();
    if !missing.is_empty() {
        return Err(DccError::Missing(missing));
    }
    let date = identity.get(Item::Date).trim();
    let date: Date = date.parse().map_err(|_| DccError::Date(date.to_owned()))?;
    let country = identity.get(Item::Country).trim().to_uppercase();
    if country.len() != 2 || !country.bytes().all(|letter| letter.is_ascii_uppercase()) {
        return Err(DccError::Country(country));
    }
    let found = report
        .uncertainty
        .as_ref()
        .map_err(|reason| DccError::NoUncertainty(reason.clone()))?;
    let mut page = Markup::default();
    page.raw("<?xml version=\"1.0\" encoding=\"UTF-8\"?>");
    let root = format!(
        "xmlns:dcc=\"https://ptb.de/dcc\" xmlns:si=\"https://ptb.de/si\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
         xsi:schemaLocation=\"https://ptb.de/dcc https://ptb.de/dcc/v{SCHEMA}/dcc.xsd\" schemaVersion=\"{SCHEMA}\""
    );
    page.within("dcc:digitalCalibrationCertificate", &root, |page| {
        page.within("dcc:administrativeData", "", |page| {
            administrative(calibration, &date.to_string(), &country, page);
            let certificate = report.certificate.as_ref();
            let verdict = certificate.map_or(Verdict::None, |own| Verdict::of(&own.checked));
            if verdict != Verdict::None {
                page.within("dcc:statements", "", |page| {
                    page.within("dcc:statement", "", |page| {
                        page.within("dcc:declaration", "", |page| {
                            content(page, "the limits that were given")
                        });
                        page.element("dcc:conformity", verdict.word());
                    });
                });
            }
        });
        page.within("dcc:measurementResults", "", |page| {
            page.within("dcc:measurementResult", "", |page| {
                named(page, "Calibration of a multi-axis force/torque sensor");
                method(calibration, page);
                page.within("dcc:results", "", |page| {
                    result(
                        page,
                        "Full scale (a nominal load), with the expanded uncertainty of a reading",
                        |page| {
                            for own in &found.axes {
                                quantity(page, own.axis, |page| {
                                    real(page, own.full_scale, own.axis, Some(own.expanded));
                                });
                            }
                        },
                    );
                    matrix(
                        page,
                        "Conventional matrix",
                        &calibration.conventional,
                        calibration,
                    );
                    if let Some(map) = &calibration.compensated {
                        matrix(page, "Compensated matrix", map, calibration);
                    }
                });
            });
        });
    });
    Ok(page.into_string())
}

fn content(page: &mut Markup, text: &str) {
    let text = text.trim();
    page.element(
        "dcc:content lang=\"en\"",
        if text.is_empty() { NOT_STATED } else { text },
    );
}

fn named(page: &mut Markup, text: &str) {
    page.within("dcc:name", "", |page| content(page, text));
}

fn administrative(calibration: &Calibration, date: &str, country: &str, page: &mut Markup) {
    let said = |item: Item| calibration.identity.get(item).trim();
    page.within("dcc:dccSoftware", "", |page| {
        page.within("dcc:software", "", |page| {
            named(page, "LoopScope");
            page.element("dcc:release", env!("CARGO_PKG_VERSION"));
        });
    });
    page.within("dcc:coreData", "", |page| {
        page.element("dcc:countryCodeISO3166_1", country);
        page.element("dcc:usedLangCodeISO639_1", "en");
        page.element("dcc:mandatoryLangCodeISO639_1", "en");
        page.element("dcc:uniqueIdentifier", said(Item::Certificate));
        page.element("dcc:beginPerformanceDate", date);
        page.element("dcc:endPerformanceDate", date);
        let place = if said(Item::Place).is_empty() {
            "laboratory"
        } else {
            "other"
        };
        page.element("dcc:performanceLocation", place);
    });
    page.within("dcc:items", "", |page| {
        page.within("dcc:item", "", |page| {
            named(page, "Multi-axis force/torque sensor");
            page.within("dcc:manufacturer", "", |page| {
                named(page, said(Item::Manufacturer))
            });
            if !said(Item::Model).is_empty() {
                page.element("dcc:model", said(Item::Model));
            }
            page.within("dcc:identifications", "", |page| {
                page.within("dcc:identification", "", |page| {
                    page.element("dcc:issuer", "manufacturer");
                    page.element("dcc:value", said(Item::Serial));
                    named(page, "Serial number");
                });
            });
        });
    });
    let contact = |page: &mut Markup, name: &str| {
        named(page, name);
        page.element("dcc:eMail", "");
        page.within("dcc:location", "", |page| {
            page.element("dcc:countryCode", country)
        });
    };
    page.within("dcc:calibrationLaboratory", "", |page| {
        page.within("dcc:contact", "", |page| {
            contact(page, said(Item::Laboratory))
        });
    });
    page.within("dcc:respPersons", "", |page| {
        let approver = said(Item::Approver);
        for (person, signs) in [
            (said(Item::Operator), approver.is_empty()),
            (approver, true),
        ] {
            if !person.is_empty() {
                page.within("dcc:respPerson", "", |page| {
                    page.within("dcc:person", "", |page| named(page, person));
                    page.element("dcc:mainSigner", if signs { "true" } else { "false" });
                });
            }
        }
    });
    page.within("dcc:customer", "", |page| {
        contact(page, said(Item::Customer))
    });
}

/// How, with what, and under which conditions.
fn method(calibration: &Calibration, page: &mut Markup) {
    let said = |item: Item| calibration.identity.get(item).trim();
    page.within("dcc:usedMethods", "", |page| {
        page.within("dcc:usedMethod", "", |page| {
            let procedure = said(Item::Procedure);
            named(
                page,
                if procedure.is_empty() {
                    "Least squares"
                } else {
                    procedure
                },
            );
            page.within("dcc:description", "", |page| {
                content(page, &calibration.describe())
            });
        });
    });
    if !said(Item::Reference).is_empty() {
        page.within("dcc:measuringEquipments", "", |page| {
            page.within("dcc:measuringEquipment", "", |page| {
                named(page, said(Item::Reference));
                let certificate = said(Item::ReferenceCertificate);
                if !certificate.is_empty() {
                    page.within("dcc:description", "", |page| {
                        content(page, &format!("Certificate: {certificate}"))
                    });
                }
                if !said(Item::ReferenceSerial).is_empty() {
                    page.within("dcc:identifications", "", |page| {
                        page.within("dcc:identification", "", |page| {
                            page.element("dcc:issuer", "manufacturer");
                            page.element("dcc:value", said(Item::ReferenceSerial));
                        });
                    });
                }
            });
        });
    }
    let conditions = [Item::Temperature, Item::Humidity]
        .into_iter()
        .filter(|item| !said(*item).is_empty());
    let conditions: Vec<Item> = conditions.collect();
    if !conditions.is_empty() {
        page.within("dcc:influenceConditions", "", |page| {
            for item in conditions {
                page.within("dcc:influenceCondition", "", |page| {
                    named(page, item.label());
                    page.within("dcc:data", "", |page| {
                        page.within("dcc:text", "", |page| content(page, said(item)));
                    });
                });
            }
        });
    }
}

fn result(page: &mut Markup, name: &str, data: impl FnOnce(&mut Markup)) {
    page.within("dcc:result", "", |page| {
        named(page, name);
        page.within("dcc:data", "", |page| page.within("dcc:list", "", data));
    });
}

fn quantity(page: &mut Markup, axis: Axis, value: impl FnOnce(&mut Markup)) {
    page.within("dcc:quantity", "", |page| {
        named(page, axis.symbol());
        value(page);
    });
}

/// The unit as D-SI spells it.
fn unit(axis: Axis) -> &'static str {
    if axis.is_force() {
        "\\newton"
    } else {
        "\\newton\\metre"
    }
}

fn real(page: &mut Markup, value: f64, axis: Axis, expanded: Option<f64>) {
    page.within("si:real", "", |page| {
        page.element("si:value", &value.to_string());
        page.element("si:unit", unit(axis));
        if let Some(expanded) = expanded {
            page.within("si:expandedUnc", "", |page| {
                page.element("si:uncertainty", &expanded.to_string());
                page.element("si:coverageFactor", &COVERAGE_FACTOR.to_string());
                page.element("si:coverageProbability", "0.9545");
                page.element("si:distribution", "normal");
            });
        }
    });
}

fn matrix(page: &mut Markup, name: &str, map: &LinearMap, calibration: &Calibration) {
    let features = map.names(&calibration.gauges).join(", ");
    result(
        page,
        &format!("{name}, of {features}, gauges in the unit of the recordings"),
        |page| {
            for (axis, row) in calibration.axes.iter().zip(&map.matrix) {
                quantity(page, *axis, |page| {
                    let values: Vec<String> = row.iter().map(f64::to_string).collect();
                    page.within("si:realListXMLList", "", |page| {
                        page.element("si:valueXMLList", &values.join(" "));
                        page.element("si:unitXMLList", unit(*axis));
                    });
                });
            }
        },
    );
}
